//! Steps whose demand is missing, or comes too late to be followed.
//!
//! In: nothing, or the displacement of the body that robots carry together, or a late demand. Out: the state that replaces the
//! demand, within the limits; and a path that knows for how long demands have been missing.

use crate::model::demand::Demand;
use crate::model::fault::Fault;
use crate::model::joints::JointVector;
use crate::model::pose::Pose;
use crate::model::robot::Robot;

use super::path::{Path, Track};
use super::{AcceptedDemand, Acceptor};

impl<R: Robot> Acceptor<R> {
    /// A demand is missing: the path's velocity is held, an acceleration fades as fast as the jerk limit allows.
    pub fn extrapolate(&mut self, duration: f64) -> AcceptedDemand<R> {
        let limits = self.checks.robot.limits();
        let state = &mut self.state;
        state.acceleration = match limits.jerk {
            Some(jerk) => R::Joints::from_joints(|i| {
                let a = state.acceleration[i];
                a - a.signum() * a.abs().min(jerk[i] * duration)
            }),
            // On its return to the path, a robot is not as fast as that.
            None if !self.track.is_followed() && state.position != self.track.path.position => {
                R::Joints::zeros()
            }
            // The robot's own velocity, after earlier losses, is that of catching up: held, it would swing to
            // and fro. Back to the path's takes (n - 1) / n of the acceleration that catching up took in n steps.
            None => {
                let limit = &limits.acceleration;
                let wanted = self.track.path.velocity - state.velocity;
                R::Joints::from_joints(|i| (wanted[i] / duration).clamp(-limit[i], limit[i]))
            }
        };
        state.velocity = state.velocity + state.acceleration * duration;
        state.position = state.position + state.velocity * duration;
        self.track.path.missing += duration;
        self.pace.period = duration;
        AcceptedDemand::new(self.state.position)
    }

    /// A demand is missing: the flange is displaced by `D` in the world, where that keeps all limits.
    ///
    /// # Errors
    /// The first limit that it breaks; nothing is changed then.
    #[allow(non_snake_case)]
    pub fn go_on(&mut self, D: &Pose, duration: f64) -> Result<AcceptedDemand<R>, Fault> {
        let displaced = self.displaced(D, duration)?;
        self.check_tool(&self.motion.tool, &displaced.position, duration)?;
        self.state.go_to(displaced.position, displaced.velocity, duration);
        self.track.bridge_on_twist(duration);
        self.pace.period = duration;
        Ok(AcceptedDemand::new(displaced.position))
    }

    /// The same while it brakes to a standstill: no demand is to come.
    ///
    /// # Errors
    /// As of [`go_on`](Acceptor::go_on).
    #[allow(non_snake_case)]
    pub fn slow_down(&mut self, D: &Pose, duration: f64) -> Result<AcceptedDemand<R>, Fault> {
        let displaced = self.displaced(D, duration)?;
        self.state.go_to(displaced.position, displaced.velocity, duration);
        self.pace.period = duration;
        self.track = Track::at(self.state.position, self.state.velocity, duration);
        Ok(AcceptedDemand::new(displaced.position))
    }

    /// Whether the robot stands, and so does its path.
    pub fn stands(&self) -> bool {
        let still = |velocity: &R::Joints| *velocity == R::Joints::zeros();
        self.track.is_followed() && still(&self.state.velocity) && still(&self.track.path.velocity)
    }

    /// A demand is missing in a standstill: of robots that move together all stand then.
    pub fn stand_by(&mut self, duration: f64) -> AcceptedDemand<R> {
        self.track.bridge_on_twist(duration);
        self.pace.period = duration;
        AcceptedDemand::new(self.state.position)
    }

    /// The first demand of a motion comes after `missed` steps in which the robot stood, and those that it moves together
    /// with: its path has begun.
    ///
    /// # Errors
    /// As of [`accept`](Acceptor::accept).
    pub fn begin_late(
        &mut self,
        demand: &Demand<R>,
        duration: f64,
        missed: f64,
        together: bool,
    ) -> Result<(), Fault> {
        let tool = self.tool_of(demand)?;
        let position = self.position_of(demand, &tool)?;
        self.next(&position, duration, false)?;
        self.motion.tool = tool;
        self.motion.starting = false;
        let from = self.end_of_path().unwrap_or(self.state.position);
        self.track.path = Path {
            missing: missed * duration,
            on_twist: together,
            late: Some(position),
            ..Path::after(from, R::Joints::zeros(), duration)
        };
        Ok(())
    }

    /// A demand came too late to be followed: its tool is in force from now on, and a path that goes no farther ends
    /// where it says. Robots with a jerk limit do not come back to their path.
    ///
    /// # Errors
    /// What is wrong with the demand itself; nothing is changed then.
    pub fn note_late(&mut self, demand: &Demand<R>) -> Result<(), Fault> {
        let tool = self.tool_of(demand)?;
        let position = self.position_of(demand, &tool)?;
        self.motion.tool = tool;
        if self.track.path.missing > 0.0 && self.checks.robot.limits().jerk.is_none() {
            self.track.path.late = Some(position);
        }
        Ok(())
    }
}
