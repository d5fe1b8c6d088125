//! How a robot comes to rest: by holding, at the end of its path or where it is, or by braking.
//!
//! In: the state demanded last. Out: the next one of the braking to a standstill.

use crate::model::fault::Fault;
use crate::model::joints::JointVector;
use crate::model::robot::Robot;
use crate::safety::braking::Braking;

use super::path::{Path, Track};
use super::{AcceptedDemand, Acceptor, RELATIVE};

impl<R: Robot> Acceptor<R> {
    /// Whether the demand stands still.
    #[cfg(test)]
    pub fn is_at_rest(&self) -> bool {
        self.state.is_at_rest()
    }

    /// Whether the path may simply stay at the state demanded last: a motion that ends at rest leaves the
    /// velocity of its last step, which one step takes away within the limits.
    pub fn can_hold(&self, duration: f64) -> bool {
        match self.end_of_path() {
            Some(end) => self.next(&end, duration, false).is_ok(),
            None => self.can_stand(duration),
        }
    }

    /// A stop ends the path where the robot is, if one step can take its velocity away; whether it does.
    pub fn stop_at_once(&mut self, duration: f64) -> bool {
        let can_stand = self.track.is_followed() && self.can_stand(duration);
        if can_stand {
            self.track.path = Path::after(self.state.position, self.state.velocity, duration);
        }
        can_stand
    }

    fn can_stand(&self, duration: f64) -> bool {
        let zeros = R::Joints::zeros();
        let acceleration = self.state.acceleration_to(&zeros, duration);
        // In the step after it the acceleration is gone, too.
        let jerk = self.checks.robot.limits().jerk;
        let is_let_go = |jerk: R::Joints| {
            (0..R::Joints::LEN).all(|i| acceleration[i].abs() <= jerk[i] * duration * (1.0 + RELATIVE))
        };
        jerk.is_none_or(is_let_go)
            && self.check(&self.state.position, &zeros, &zeros, &acceleration, duration).is_ok()
    }

    /// Whether the robot is where its path ends, if that goes no farther, and a motion may begin there: with a jerk limit, only
    /// once there is no acceleration left that would add to that motion's own.
    pub fn is_at_its_end(&self) -> bool {
        let zeros = R::Joints::zeros();
        let has_let_go = self.state.velocity == zeros && self.state.acceleration == zeros;
        self.end_of_path().is_none() && (has_let_go || self.checks.robot.limits().jerk.is_none())
    }

    /// Stay: the state demanded last is demanded again. The path's speed is kept: a robot whose ECP transmits orders is
    /// held so in a suspension. One that is off its path comes back to it, and to where it ends: the last demand of a motion
    /// may have been late.
    ///
    /// # Errors
    /// The limit that the return to the path would break; nothing is changed then.
    pub fn hold(&mut self, duration: f64) -> Result<AcceptedDemand<R>, Fault> {
        if let Some(end) = self.end_of_path() {
            let next = self.next(&end, duration, false)?;
            return Ok(self.take(next, duration));
        }
        let zeros = R::Joints::zeros();
        self.state.go_to(self.state.position, zeros, duration);
        self.track.path = Path::after(self.state.position, zeros, duration);
        Ok(AcceptedDemand::new(self.state.position))
    }

    /// The braking to a standstill from here.
    pub fn braking(&self) -> Braking<R::Joints> {
        let limits = self.checks.robot.limits();
        let state = &self.state;
        Braking::new(state.position, state.velocity, state.acceleration, limits)
    }

    /// The next state of that braking.
    pub fn brake(&mut self, braking: &mut Braking<R::Joints>, duration: f64) -> AcceptedDemand<R> {
        let (position, velocity) = braking.advance(duration);
        self.state.go_to(position, velocity, duration);
        self.track = Track::at(position, velocity, duration);
        AcceptedDemand::new(position)
    }
}
