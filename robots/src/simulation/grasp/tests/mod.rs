//! Bodies in grippers that stand still or are led by hand, against statics and mechanics.

mod belt;
mod bench;
mod contact;
mod dynamics;
mod internal;
mod pads;
mod plate;
mod refusals;
mod statics;
mod time;
mod wrist;

use bench::Bench;
