//! A device with inputs and outputs and no joints: switches, valves and lamps on a controller of their own.
//!
//! **Joints.** None: there is nothing to move, so a demand can only hold, and switch. **Pose.** It is nowhere but at the origin of the
//! world; every other pose is refused.

use mrroc::prelude::*;
use mrroc::robot::{Limits, NoInverse};
use nalgebra::SVector;

/// The joints of a device without any.
pub type NoJoints = SVector<f64, 0>;

/// A device with inputs and outputs and no joints.
///
/// ```
/// use mrroc::prelude::*;
/// use mrroc_robots::{IoBlock, NoJoints};
///
/// let block = IoBlock::new();
/// assert_eq!(block.forward(&NoJoints::zeros()), Pose::identity());
/// assert!(block.inverse(&Pose::translation(0.0, 0.0, 0.1), &NoJoints::zeros()).is_err());
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct IoBlock {
    limits: Limits<NoJoints>,
}

impl IoBlock {
    /// One.
    #[must_use]
    pub fn new() -> Self {
        let none = NoJoints::zeros();
        IoBlock {
            limits: Limits { lower: none, upper: none, velocity: none, acceleration: none, jerk: None },
        }
    }
}

impl Default for IoBlock {
    fn default() -> Self {
        Self::new()
    }
}

impl Robot for IoBlock {
    const KIND: &'static str = "io-block";

    type Joints = NoJoints;

    fn limits(&self) -> &Limits<NoJoints> {
        &self.limits
    }

    fn forward(&self, _: &NoJoints) -> Pose {
        Pose::identity()
    }

    #[allow(non_snake_case)]
    fn inverse(&self, X_WF: &Pose, near: &NoJoints) -> Result<NoJoints, NoInverse> {
        let distance = X_WF.translation.vector.norm();
        if distance > 0.0 || X_WF.rotation.angle() > 0.0 {
            return Err(NoInverse::OutOfReach { distance, min: 0.0, max: 0.0 });
        }
        Ok(*near)
    }
}
