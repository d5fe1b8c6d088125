//! Where a robot is at the end of a step: at its demand, or on its return to the path.
//!
//! In: the joints of a demand, or a displacement in place of one. Out: a state whose limits have been checked.

use crate::model::fault::Fault;
use crate::model::pose::Pose;
use crate::model::robot::Robot;
use crate::safety::common_twist::Twist;

use super::Acceptor;
use super::catching_up::{CatchingUp, Late};
use super::path::{OffPath, Track};
use super::rejoining::{GapTwists, Rejoining};

/// A state for the end of a step.
pub(super) struct NextState<J> {
    pub position: J,
    pub velocity: J,
    pub track: Track<J>,
}

/// A state to which a missing demand brings the robot.
pub(super) struct Displaced<J> {
    pub position: J,
    pub velocity: J,
}

impl<R: Robot> Acceptor<R> {
    /// The state at the end of a step in which the path goes to `demand`: at the demand; or, when demands were late and the
    /// limits do not allow the robot to be there yet, on the return to the path.
    pub(super) fn next(
        &self,
        demand: &R::Joints,
        duration: f64,
        all_missed: bool,
    ) -> Result<NextState<R::Joints>, Fault> {
        if self.track.is_in_step() {
            return self.there(demand, duration);
        }
        let missed = (self.track.path.missing / duration).round();
        let rejoining = match &self.track.off_path {
            Some(OffPath::Together(rejoining)) if missed == 0.0 || self.track.path.on_twist => {
                Some(rejoining)
            }
            Some(_) | None => None,
        };
        // One that is off its path by its joints does not come back with the others.
        let with_others =
            self.track.path.on_twist && !matches!(self.track.off_path, Some(OffPath::Joints(_)));
        let rejoin = || {
            let robot = &self.checks.robot;
            let [from, to, at] =
                [&self.track.path.position, demand, &self.state.position].map(|joints| robot.forward(joints));
            let twists = GapTwists {
                last: self.track.path_twist(robot, duration),
                over: Twist::between(&from, &to),
                bridged: Twist::between(&from, &at),
                change: self.state.twist(robot, duration),
            };
            self.beside(demand, Rejoining::after(rejoining, &twists, missed), duration)
        };
        if all_missed && with_others {
            return rejoin();
        }
        let there = match rejoining.and_then(|rejoining| rejoining.advanced(missed + 1.0)) {
            Some(rejoining) => self.beside(demand, rejoining, duration),
            None => self.there(demand, duration),
        };
        let comes_back = self.end_of_path().is_some();
        match there {
            Ok(next) if rejoining.is_some() || with_others || !comes_back => Ok(next),
            // Whether the others missed a demand, too, is not known: at worst this one is beside them for a while.
            Err(_) if with_others => rejoin(),
            Err(fault) if rejoining.is_some() || !comes_back => Err(fault),
            // Even a demand that can be taken at once is one to come back to: the robot is not as fast as the path there.
            there => self.back(demand, duration)?.map_or(there, Ok),
        }
    }

    /// The state beside a demand, where all robots that this one moves together with are beside theirs.
    #[allow(non_snake_case)]
    fn beside(
        &self,
        demand: &R::Joints,
        rejoining: Rejoining,
        duration: f64,
    ) -> Result<NextState<R::Joints>, Fault> {
        let X_WF = rejoining.displacement() * self.checks.robot.forward(demand);
        let position = self.flange_joints(&X_WF, demand)?;
        let velocity = self.velocity_to(&position, None, duration)?;
        let off_path = Some(OffPath::Together(rejoining));
        let track = Track { path: self.track.path_to(demand, duration), off_path };
        Ok(NextState { position, velocity, track })
    }

    /// The state at a demand.
    fn there(&self, demand: &R::Joints, duration: f64) -> Result<NextState<R::Joints>, Fault> {
        let path = self.track.path_to(demand, duration);
        let velocity = self.velocity_to(demand, Some(&path.velocity), duration)?;
        Ok(NextState { position: *demand, velocity, track: Track { path, off_path: None } })
    }

    /// A state on the return to the path; `None` if the path is too far away.
    fn back(&self, demand: &R::Joints, duration: f64) -> Result<Option<NextState<R::Joints>>, Fault> {
        let path = self.track.path_to(demand, duration);
        // Both velocities are those of the middles of their times.
        let acceleration =
            (path.velocity - self.track.path.velocity) * (0.5 * (path.span + self.track.path.span)).recip();
        self.check(demand, &path.velocity, &path.velocity, &acceleration, duration)?;
        let late = Late {
            position: &self.state.position,
            velocity: &self.state.velocity,
            demand,
            before: &self.track.path.position,
            path_velocity: &path.velocity,
            path_acceleration: &acceleration,
            time: path.span,
            duration,
        };
        let known = match &self.track.off_path {
            Some(OffPath::Joints(known)) => Some(known),
            Some(OffPath::Together(_)) | None => None,
        };
        let Some((position, off_path)) = CatchingUp::next(known, &late, self.checks.robot.limits()) else {
            return Ok(None);
        };
        let velocity = self.velocity_to(&position, None, duration)?;
        let off_path = off_path.map(OffPath::Joints);
        Ok(Some(NextState { position, velocity, track: Track { path, off_path } }))
    }

    /// The state that the flange has once it is displaced by `D` in the world.
    #[allow(non_snake_case)]
    pub(super) fn displaced(&self, D: &Pose, duration: f64) -> Result<Displaced<R::Joints>, Fault> {
        let X_WF = D * self.checks.robot.forward(&self.state.position);
        let position = self.flange_joints(&X_WF, &self.state.position)?;
        let velocity = self.velocity_to(&position, None, duration)?;
        Ok(Displaced { position, velocity })
    }
}
