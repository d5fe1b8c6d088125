//! How the joints of a robot accelerate on a screw along which its flange goes at constant velocity.
//!
//! In: the state demanded last, and the screw that led to it. Out: the acceleration \[rad/s² or m/s²\] that a screw takes of each
//! joint's limit before braking takes any. Bent in joint space it is near a singular posture most of all.

use crate::model::joints::JointVector;
use crate::model::robot::Robot;

use super::Acceptor;

/// The screw's curvature in joint space is found by an inverse kinematics of its own. A posture changes little in so many
/// steps.
const STEPS: u32 = 4;

/// What is known of it.
#[derive(Clone, Copy)]
pub(super) struct Curvature<J> {
    /// Of each joint \[rad/s² or m/s²\].
    pub acceleration: J,
    /// The steps for which it holds.
    left: u32,
}

impl<J: JointVector> Curvature<J> {
    /// Of a robot that is on no screw.
    pub fn none() -> Self {
        Curvature { acceleration: J::zeros(), left: 0 }
    }
}

impl<R: Robot> Acceptor<R> {
    /// Looks at the curvature of the screw on which the robot moves together with others, in steps of `duration` \[s\]. A screw on
    /// which the kinematics has no next step leaves what was seen before.
    pub fn look_along_screw(&mut self, duration: f64) {
        if self.curvature.left > 0 {
            self.curvature.left -= 1;
            return;
        }
        self.curvature.left = STEPS - 1;
        // One that is on its way back to its path is elsewhere on its screw; what was seen before holds.
        if !self.track.is_followed() {
            return;
        }
        let next = self.state.screw(&self.checks.robot, duration).part(1.0)
            * self.checks.robot.forward(&self.state.position);
        if let Ok(position) = self.flange_joints(&next, &self.state.position) {
            let velocity = (position - self.state.position) * duration.recip();
            self.curvature.acceleration = self.state.acceleration_to(&velocity, duration);
        }
    }

    /// The robot moves by itself: there is no screw.
    pub fn leave_screw(&mut self) {
        self.curvature = Curvature::none();
    }
}
