//! The state that a robot's drives were demanded last, joint by joint.
//!
//! In: accepted positions and velocities. Out: the same, with the acceleration that they make of the step.

use crate::model::joints::JointVector;
use crate::model::robot::Robot;
use crate::safety::common_twist::Twist;

/// Where the joints are demanded to be, and how they move there.
#[derive(Clone, Copy, Debug)]
pub(super) struct JointState<J> {
    /// [rad or m].
    pub position: J,
    /// The mean of the last step [rad/s or m/s].
    pub velocity: J,
    /// From the mean velocity of the step before to that of the last one [rad/s² or m/s²].
    pub acceleration: J,
}

impl<J: JointVector> JointState<J> {
    /// At rest at `position`.
    pub fn at_rest(position: J) -> Self {
        JointState { position, velocity: J::zeros(), acceleration: J::zeros() }
    }

    /// Whether it stands still.
    pub fn is_at_rest(&self) -> bool {
        // 1e-9 rad/s is round-off of positions over a step; a standstill by safety.md is 1e-3 rad/s.
        self.velocity.as_slice().iter().all(|v| v.abs() <= 1e-9)
    }

    /// The acceleration that brings it to a velocity in a step of `duration` \[s\].
    pub fn acceleration_to(&self, velocity: &J, duration: f64) -> J {
        (*velocity - self.velocity) * duration.recip()
    }

    /// The displacement of the flange in the last step of `duration` \[s\], in the world.
    pub fn twist<R: Robot<Joints = J>>(&self, robot: &R, duration: f64) -> Twist {
        let before = self.position - self.velocity * duration;
        Twist::between(&robot.forward(&before), &robot.forward(&self.position))
    }

    /// By how much that displacement differs from the one of the step before.
    pub fn bend<R: Robot<Joints = J>>(&self, robot: &R, duration: f64) -> Twist {
        let velocity = self.velocity - self.acceleration * duration;
        let before = JointState { position: self.position - self.velocity * duration, velocity, ..*self };
        self.twist(robot, duration) - before.twist(robot, duration)
    }

    /// A step of `duration` \[s\] at `velocity` ends at `position`.
    pub fn go_to(&mut self, position: J, velocity: J, duration: f64) {
        self.acceleration = self.acceleration_to(&velocity, duration);
        self.velocity = velocity;
        self.position = position;
    }
}
