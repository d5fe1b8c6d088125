//! Where a robot is at the end of a step: at its demand, or on its way back to the path.
//!
//! In: the joints of a demand, or a displacement in place of one. Out: a state whose limits have been checked.

use crate::model::fault::Fault;
use crate::model::pose::Pose;
use crate::model::robot::Robot;
use crate::safety::screw::Screw;

use super::catching_up::{CatchingUp, Late};
use super::rejoining::Rejoining;
use super::{Acceptor, Next, OffPath, Path};

impl<R: Robot> Acceptor<R> {
    /// The state at the end of a step in which the path goes to `demand`: there, or, where demands were late and the limits
    /// do not allow that, on the way back to the path.
    pub(super) fn next(
        &self,
        demand: &R::Joints,
        duration: f64,
        all_missed: bool,
    ) -> Result<Next<R::Joints>, Fault> {
        let missed = (self.path.missing / duration).round();
        let way = match &self.off_path {
            Some(OffPath::Together(way)) if missed == 0.0 || self.path.on_screw => Some(way),
            Some(_) | None => None,
        };
        // One that is off its path by its joints does not come back with the others.
        let with_others = self.path.on_screw && !matches!(self.off_path, Some(OffPath::Joints(_)));
        let rejoin = || {
            let over = Screw::between(&self.robot.forward(&self.path.position), &self.robot.forward(demand));
            let way = Rejoining::after(way, self.path_screw(duration), over, missed);
            self.beside(demand, way, duration)
        };
        if all_missed && with_others {
            return rejoin();
        }
        let there = match way.and_then(|way| way.advanced(missed + 1.0)) {
            Some(way) => self.beside(demand, way, duration),
            None => self.there(demand, duration),
        };
        let comes_back = self.end_of_path().is_some();
        match there {
            Ok(next) if way.is_some() || with_others || !comes_back => Ok(next),
            // Whether the others missed a demand, too, is not known: at worst this one is beside them for a while.
            Err(_) if with_others => rejoin(),
            Err(fault) if way.is_some() || !comes_back => Err(fault),
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
    ) -> Result<Next<R::Joints>, Fault> {
        let X_WF = rejoining.displacement() * self.robot.forward(demand);
        let position = self.flange_joints(&X_WF, demand)?;
        let velocity = self.velocity_to(&position, None, duration)?;
        let off_path = Some(OffPath::Together(rejoining));
        Ok(Next { position, velocity, path: self.path_to(demand, duration), off_path })
    }

    /// The state at a demand.
    fn there(&self, demand: &R::Joints, duration: f64) -> Result<Next<R::Joints>, Fault> {
        let path = self.path_to(demand, duration);
        let velocity = self.velocity_to(demand, Some(&path.velocity), duration)?;
        Ok(Next { position: *demand, velocity, path, off_path: None })
    }

    /// A state on the way back to the path; none where that is too far.
    fn back(&self, demand: &R::Joints, duration: f64) -> Result<Option<Next<R::Joints>>, Fault> {
        let path = self.path_to(demand, duration);
        // Both velocities are those of the middles of their times.
        let acceleration =
            (path.velocity - self.path.velocity) * (0.5 * (path.span + self.path.span)).recip();
        self.check(demand, &path.velocity, &path.velocity, &acceleration, duration)?;
        let late = Late {
            position: &self.position,
            velocity: &self.velocity,
            demand,
            before: &self.path.position,
            path_velocity: &path.velocity,
            path_acceleration: &acceleration,
            time: path.span,
            duration,
        };
        let known = match &self.off_path {
            Some(OffPath::Joints(known)) => Some(known),
            Some(OffPath::Together(_)) | None => None,
        };
        let Some((position, off_path)) = CatchingUp::next(known, &late, self.robot.limits()) else {
            return Ok(None);
        };
        let velocity = self.velocity_to(&position, None, duration)?;
        Ok(Some(Next { position, velocity, path, off_path: off_path.map(OffPath::Joints) }))
    }

    /// The path once it has come to `demand`.
    fn path_to(&self, demand: &R::Joints, duration: f64) -> Path<R::Joints> {
        let span = self.path.missing + duration;
        Path::after(*demand, (*demand - self.path.position) * span.recip(), span)
    }

    /// The displacement of the last step in the world: the path's, and that of the way back to it.
    pub fn screw(&self, duration: f64) -> Screw {
        match &self.off_path {
            Some(OffPath::Together(way)) => self.path_screw(duration) + way.change(),
            Some(OffPath::Joints(_)) | None => self.path_screw(duration),
        }
    }

    /// The displacement of the path's last step in the world, as its mean velocity makes it.
    fn path_screw(&self, duration: f64) -> Screw {
        let before = self.path.position - self.path.velocity * duration;
        let of_joints =
            || Screw::between(&self.robot.forward(&before), &self.robot.forward(&self.path.position));
        match &self.off_path {
            Some(OffPath::Together(way)) => way.path_screw().unwrap_or_else(of_joints),
            Some(OffPath::Joints(_)) | None => of_joints(),
        }
    }

    /// The joints, and their velocity, that displace the flange by `D` in the world.
    #[allow(non_snake_case)]
    pub(super) fn displaced(&self, D: &Pose, duration: f64) -> Result<(R::Joints, R::Joints), Fault> {
        let X_WF = D * self.robot.forward(&self.position);
        let position = self.flange_joints(&X_WF, &self.position)?;
        Ok((position, self.velocity_to(&position, None, duration)?))
    }
}
