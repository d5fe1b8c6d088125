//! Multi-robot research-oriented controller.

mod driver;
mod joints;
mod pose;
mod robot;

pub use driver::{DriveFault, Driver, Measured};
pub use joints::{JointVector, MAX_JOINTS};
pub use pose::{AngleAxis, Pose, Zyz};
pub use robot::{Limits, NoInverse, Robot};
