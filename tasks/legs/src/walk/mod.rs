//! How to walk, without a robot and a runtime: the gait, the support polygon, a footstep and whether it may be made.

mod course;
mod footstep;
mod gait;
pub mod support;
mod swing;

pub use course::{Course, regular};
pub use footstep::{Footstep, LEAST, Refused, Stance};
pub use gait::{Gait, Part, soft};
pub use swing::Swing;
