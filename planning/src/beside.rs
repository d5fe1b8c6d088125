//! What robots pass through that move by a plan of their own, or stand: others plan beside it.
//!
//! In: a plan, or a position. Out: capsules in the world that hold all that a robot may pass through: in its motion and in all its stops,
//! at whatever time. A piece of the path, and the states of the stops from there, are boxes of joint positions ([`Swept`]); a link in such a
//! box is a capsule that is larger by how far the link may get. Where it is much larger, the piece is cut in two for this link.

use core::ops::Range;

use mrroc::robot::MAX_JOINTS;
use mrroc_robots::clearance::{Capsule, RobotPart};

use crate::error::PlanError;
use crate::plan::{Motion, Plan};
use crate::planner::Planner;
use crate::stop::Swept;
use crate::timing::{Passed, grid};

/// By how much capsules may be larger than links before a piece is cut \[m\]; more where there were too many of them.
const EXCESS: f64 = 0.01;
/// The most capsules of a robot.
const MOST: usize = 100_000;
/// The shortest piece, of the path [rad or m] and of a stop.
const SHORTEST: f64 = 1e-3;

impl Planner {
    /// A planner for the other robots, while those of `plan` follow it from the path time `from` \[s\] on. Start and goals of its plans are
    /// those of the robots that are left.
    ///
    /// They keep apart from all that the robots of `plan` may pass through from there on, in the motion and in every stop of it, at whatever
    /// time: either motion may begin later, be suspended or go on at another speed. Its proof holds for the reaction time of that plan, and for
    /// robots that follow it as it is. Where nothing of `plan` is left, its robots stand at its end.
    ///
    /// # Errors
    /// [`PlanError::NoRobot`], [`PlanError::Joints`]: the planner has no such robot, or it has other joints; [`PlanError::Robots`]: no robot
    /// is left; [`PlanError::Coupled`]: joints that share limits have no posture in a stop.
    pub fn beside(&self, plan: &Plan, from: f64) -> Result<Planner, PlanError> {
        let mut planner = self.clone();
        for robot in &plan.robots {
            let joints = plan.motion.limits.robots[plan.place_of(robot.as_str())?].clone();
            let part = planner.part(robot.as_str(), joints.len())?;
            let mut excess = EXCESS;
            let capsules = loop {
                let found = Vec::new();
                let mut sweep = Sweep { part, motion: &plan.motion, joints: joints.clone(), excess, found };
                match sweep.all(from) {
                    Ok(()) => break sweep.found,
                    Err(Refused::TooMany) => excess *= 2.0,
                    Err(Refused::NoPosture) => {
                        return Err(PlanError::Coupled { place: "stop", robot: robot.to_string() });
                    }
                }
            };
            planner = planner.without(robot.as_str(), &capsules)?;
        }
        planner.has_robots()
    }

    /// A planner for the other robots, while `robot` stands at `joints` [rad or m].
    ///
    /// # Errors
    /// [`PlanError::NoRobot`], [`PlanError::Joints`], [`PlanError::Coupled`]; [`PlanError::Robots`]: no robot is left.
    pub fn beside_standing(&self, robot: &str, joints: &[f64]) -> Result<Planner, PlanError> {
        let part = self.part(robot, joints.len())?;
        let mut capsules = Vec::new();
        let q: [f64; MAX_JOINTS] = core::array::from_fn(|j| joints.get(j).copied().unwrap_or_default());
        let is_finite = q.iter().all(|q| q.is_finite());
        let mut keep = |link, capsule, _| capsules.push((link, capsule));
        if !(is_finite && part.around(&q, &[0.0; MAX_JOINTS], &mut keep)) {
            return Err(PlanError::Coupled { place: "standing position", robot: robot.to_owned() });
        }
        self.without(robot, &capsules)?.has_robots()
    }

    /// The robot of this name, which must have so many joints.
    fn part(&self, robot: &str, joints: usize) -> Result<&RobotPart, PlanError> {
        let arm = self.arm(robot)?;
        if arm.joints == joints {
            Ok(&arm.part)
        } else {
            Err(PlanError::Joints { expected: arm.joints, actual: joints })
        }
    }

    /// The same without a robot, which is these capsules now.
    fn without(&self, robot: &str, capsules: &[(usize, Capsule)]) -> Result<Planner, PlanError> {
        let clearance = self.clearance().with_robot_as_obstacles(robot, capsules);
        Ok(self.with_clearance(clearance.map_err(|error| PlanError::Clearance(Box::new(error)))?))
    }
}

/// Collects what a robot passes through.
struct Sweep<'a> {
    part: &'a RobotPart,
    motion: &'a Motion,
    /// Its joints in the plan.
    joints: Range<usize>,
    excess: f64,
    found: Vec<(usize, Capsule)>,
}

/// Why it cannot be collected.
enum Refused {
    TooMany,
    NoPosture,
}

/// A piece of the path, and of the stops from there.
#[derive(Clone, Copy)]
struct Piece {
    path: [f64; 2],
    /// Shares of the stop.
    stop: [f64; 2],
    /// The largest speed on the piece, and until robots brake [1/s].
    speed: f64,
}

impl Sweep<'_> {
    /// What it passes through from a path time on.
    fn all(&mut self, from: f64) -> Result<(), Refused> {
        let Motion { path, speed, reaction, ends, .. } = self.motion;
        // Where it stands at last, to the last digit.
        let end = self.own(|j| ends[1][j]);
        self.part.around(&end, &[0.0; MAX_JOINTS], &mut |link, capsule, _| self.found.push((link, capsule)));
        if from >= speed.duration() {
            return Ok(());
        }
        let links: Vec<usize> = (0..self.part.links.len()).collect();
        let begin = speed.at(from.max(speed.begins)).s;
        let grid = grid(path);
        let passed = Passed::of(&grid, speed);
        for (cell, ends) in grid.windows(2).enumerate().filter(|(_, ends)| begin < ends[1]) {
            let (_, speed) = passed.ahead(cell, grid.len() - 1, *reaction);
            let path = [ends[0].max(begin), ends[1]];
            self.piece(Piece { path, stop: [0.0, 1.0], speed }, &links)?;
        }
        Ok(())
    }

    /// What some links pass through on a piece.
    fn piece(&mut self, piece: Piece, links: &[usize]) -> Result<(), Refused> {
        let Motion { path, limits, reaction, offset, .. } = self.motion;
        let swept = Swept::new(path, piece.path, piece.speed, limits, *reaction);
        let places = self.own(|j| {
            let [middle, half] = swept.between(j, piece.stop);
            [middle + offset[j], half]
        });
        let [q, off] = [0, 1].map(|i| places.map(|place| place[i]));
        // What is gained by cutting the path, and the stops.
        let along_path = 0.5 * (piece.path[1] - piece.path[0]);
        let along_stop = 0.5 * (piece.stop[1] - piece.stop[0]) * swept.longest(self.joints.clone());
        let widest = off.iter().copied().fold(0.0, f64::max);
        let is_last = along_path.max(along_stop) < SHORTEST.max(0.1 * widest);
        let mut left = Vec::new();
        let (found, excess) = (&mut self.found, self.excess);
        let mut wanted = links.iter().copied().peekable();
        let stands = self.part.around(&q, &off, &mut |link, capsule, more| {
            if wanted.next_if_eq(&link).is_none() {
                return;
            }
            if more <= excess || is_last {
                found.push((link, capsule));
            } else {
                left.push(link);
            }
        });
        if self.found.len() > MOST {
            return Err(Refused::TooMany);
        }
        if !stands {
            // In the middle of a piece joints that share limits may have no posture.
            left = links.to_vec();
        }
        if left.is_empty() {
            return Ok(());
        }
        if is_last {
            return Err(Refused::NoPosture);
        }
        let halves = |[from, to]: [f64; 2]| [[from, 0.5 * (from + to)], [0.5 * (from + to), to]];
        let parts = if along_path >= along_stop {
            halves(piece.path).map(|path| Piece { path, ..piece })
        } else {
            halves(piece.stop).map(|stop| Piece { stop, ..piece })
        };
        parts.into_iter().try_for_each(|part| self.piece(part, &left))
    }

    /// A value for each joint of the robot, of those of the plan.
    fn own<T: Default>(&self, of: impl Fn(usize) -> T) -> [T; MAX_JOINTS] {
        core::array::from_fn(|j| if j < self.joints.len() { of(self.joints.start + j) } else { T::default() })
    }
}
