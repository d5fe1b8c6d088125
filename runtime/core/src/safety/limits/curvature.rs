//! How the joints of a robot accelerate on a twist along which its flange goes at constant velocity.
//!
//! In: the state demanded last, and the twist that led to it. Out: the acceleration \[rad/s² or m/s²\] that a twist takes of each
//! joint's limit before braking takes any. Bent in joint space it is near a singular posture most of all.

use crate::model::joints::JointVector;
use crate::model::robot::Robot;

use super::Acceptor;

/// For how long \[s\] what was seen of a curvature holds: a posture changes little meanwhile, and to look takes an inverse
/// kinematics of its own. The speed may change much, and the acceleration by its square.
const HOLDS: f64 = 0.016;

/// What is known of it.
#[derive(Clone, Copy)]
pub(super) struct Curvature<J> {
    /// Of each joint \[rad/s² or m/s²\], at the speed of then.
    acceleration: J,
    /// That speed: the largest share of a velocity limit.
    speed: f64,
    /// For how much longer it holds \[s\].
    left: f64,
}

impl<J: JointVector> Curvature<J> {
    /// Of a robot that is on no twist.
    pub fn none() -> Self {
        Curvature { acceleration: J::zeros(), speed: 0.0, left: 0.0 }
    }
}

impl<R: Robot> Acceptor<R> {
    /// Looks at the curvature of the twist on which the robot moves together with others, in steps of `duration` \[s\]. A twist on
    /// which the kinematics has no next step leaves what was seen before.
    pub fn look_along_twist(&mut self, duration: f64) {
        self.curvature.left -= duration;
        // Half a step is round-off. One that stood when it was looked at has been seen on no twist.
        if self.curvature.left > 0.5 * duration && self.curvature.speed > 0.0 {
            return;
        }
        self.curvature.left = HOLDS;
        // One that is on its return to its path is elsewhere on its twist; what was seen before holds.
        if !self.track.is_followed() {
            return;
        }
        let robot = &self.checks.robot;
        let state = &self.state;
        let now = robot.forward(&state.position);
        let before = robot.forward(&(state.position - state.velocity * duration));
        // The displacement of the last step in the world, once more.
        let next = now * before.inv_mul(&now);
        if let Ok(position) = self.flange_joints(&next, &state.position) {
            let velocity = (position - state.position) * duration.recip();
            self.curvature.acceleration = state.acceleration_to(&velocity, duration);
            self.curvature.speed = self.speed();
        }
    }

    /// The acceleration of each joint \[rad/s² or m/s²\] on the twist at the present speed.
    pub(super) fn curvature(&self) -> R::Joints {
        let Curvature { acceleration, speed, .. } = self.curvature;
        // A robot that stood has been seen on no twist.
        if speed > 0.0 { acceleration * (self.speed() / speed).powi(2) } else { R::Joints::zeros() }
    }

    /// The largest share of a velocity limit that a joint has.
    fn speed(&self) -> f64 {
        let limit = self.checks.robot.limits().velocity;
        (0..R::Joints::LEN).map(|i| self.state.velocity[i].abs() / limit[i]).fold(0.0, f64::max)
    }

    /// As if it had just been seen.
    #[cfg(test)]
    pub(super) fn see_curvature(&mut self, acceleration: R::Joints) {
        self.curvature = Curvature { acceleration, speed: self.speed(), left: HOLDS };
    }

    /// The robot moves by itself: there is no twist.
    pub fn leave_twist(&mut self) {
        self.curvature = Curvature::none();
    }
}
