//! A plan: a motion of all joints over path time.

use std::sync::Arc;

use mrroc::fault::Name;

use crate::error::PlanError;
use crate::limits::Limits;
use crate::path::Path;
use crate::speed::Speed;

/// A motion of one to four robots whose path and whose stops are clear; made by a [`Planner`](crate::Planner).
#[derive(Clone, Debug)]
pub struct Plan {
    pub(crate) robots: Vec<Name>,
    pub(crate) motion: Arc<Motion>,
}

/// The motion of all joints.
#[derive(Debug)]
pub(crate) struct Motion {
    pub(crate) path: Path,
    pub(crate) speed: Speed,
    pub(crate) limits: Limits,
    /// Whole turns that endless joints are off what the path says [rad].
    pub(crate) offset: Vec<f64>,
    /// Where it begins and ends, to the last digit [rad or m].
    pub(crate) ends: [Vec<f64>; 2],
    /// The cells of its path from each of which stops are proven: where they begin, and the end.
    pub(crate) grid: Vec<f64>,
    /// Until this path time \[s\] it is the plan that it was made from, if it was made from one.
    pub(crate) leaves: f64,
    /// The time from a fault until the last robot brakes, for which its stops are proven \[s\], >= 0.
    pub(crate) reaction: f64,
    /// Whether its robots hold one body together, so that no other motion of their joints may follow.
    pub(crate) carries: bool,
}

impl Plan {
    /// The path time at which the motion ends \[s\]: how long it lasts at full speed. A plan that robots are handed over to counts on from the plan
    /// before it.
    #[must_use]
    pub fn duration(&self) -> f64 {
        self.motion.speed.duration()
    }

    /// The joint positions [rad or m] of all robots, one behind the other, at a path time \[s\]: before it begins where it does, from the duration
    /// on where it ends.
    #[must_use]
    pub fn at(&self, time: f64) -> Vec<f64> {
        (0..self.motion.limits.joints()).map(|joint| self.motion.joint_at(time, joint)).collect()
    }

    /// Length of the path: the root of the sum of squares over all joints [rad or m].
    #[must_use]
    pub fn length(&self) -> f64 {
        self.motion.path.length()
    }

    /// The same motion from a path time \[s\] on, without what lies before.
    pub(crate) fn since(&self, time: f64) -> Self {
        let Motion { path, speed, limits, offset, ends, grid, leaves, reaction, carries } = &*self.motion;
        if !(time > speed.begins && time < speed.duration()) {
            return self.clone();
        }
        let begin = (0..limits.joints()).map(|joint| self.motion.joint_at(time, joint)).collect();
        let (path, first) = path.since(speed.at(time).s);
        let grid = grid.iter().map(|u| u - first).filter(|u| *u > 0.0);
        let motion = Motion {
            path,
            speed: speed.since(time, first),
            limits: limits.clone(),
            offset: offset.clone(),
            ends: [begin, ends[1].clone()],
            grid: core::iter::once(0.0).chain(grid).collect(),
            leaves: *leaves,
            reaction: *reaction,
            carries: *carries,
        };
        Plan { robots: self.robots.clone(), motion: Arc::new(motion) }
    }

    /// The place of a robot among those of the plan.
    pub(crate) fn place_of(&self, robot: &str) -> Result<usize, PlanError> {
        let place = self.robots.iter().position(|name| name.as_str() == robot);
        place.ok_or_else(|| PlanError::no_robot(robot, self.robots.iter().copied()))
    }
}

impl Motion {
    /// The position of a joint at a path time \[s\].
    pub(crate) fn joint_at(&self, time: f64, joint: usize) -> f64 {
        if time <= self.speed.begins {
            self.ends[0][joint]
        } else if time >= self.speed.duration() {
            self.ends[1][joint]
        } else {
            self.place(self.speed.at(time).s, joint)
        }
    }

    /// The position of a joint at a parameter of the path.
    pub(crate) fn place(&self, u: f64, joint: usize) -> f64 {
        self.path.joint_at(u, joint) + self.offset[joint]
    }
}
