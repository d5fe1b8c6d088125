//! Motions, a file each; `mrroc-new generator --list` shows those of the library, to be copied and changed.

mod steer;
pub use steer::{SPEED, Steer};
