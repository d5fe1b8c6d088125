//! A plan: a motion of all joints over path time, and how near it comes to what is around.

use std::sync::Arc;

use mrroc::fault::Name;
use mrroc_robots::clearance::{Clearance, Nearest};

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
}

/// The nearest that robots come to something, and when.
#[derive(Clone, Debug, PartialEq)]
pub struct Closest {
    /// Path time from the beginning of the motion \[s\].
    pub time: f64,
    /// Both bodies and their distance.
    pub nearest: Nearest,
}

impl Plan {
    /// How long the motion lasts at full speed \[s\].
    #[must_use]
    pub fn duration(&self) -> f64 {
        self.motion.speed.duration()
    }

    /// The joint positions [rad or m] of all robots, one behind the other, at a path time \[s\]: before 0 where it begins, from the duration
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

    /// The smallest clearance of the motion, looked at every `step` \[s\], > 0.
    ///
    /// # Errors
    /// [`PlanError::Check`]: the clearance is of other robots.
    pub fn closest(&self, clearance: &mut Clearance, step: f64) -> Result<Closest, PlanError> {
        let count = (self.duration() / step).ceil().max(1.0) as usize;
        let mut closest: Option<Closest> = None;
        for k in 0..=count {
            let time = k as f64 * step;
            let q = self.at(time);
            let robots: Vec<&[f64]> =
                self.motion.limits.robots.iter().map(|range| &q[range.clone()]).collect();
            let nearest = clearance.nearest_at(&robots)?;
            if closest.as_ref().is_none_or(|closest| nearest.distance < closest.nearest.distance) {
                closest = Some(Closest { time, nearest });
            }
        }
        closest.ok_or(PlanError::Check(mrroc_robots::clearance::CheckError::NothingToCheck))
    }

    /// The place of a robot among those of the plan.
    pub(crate) fn place_of(&self, robot: &str) -> Result<usize, PlanError> {
        self.robots.iter().position(|name| name.as_str() == robot).ok_or_else(|| PlanError::NoRobot {
            name: robot.to_owned(),
            known: self.robots.iter().map(Name::as_str).collect::<Vec<_>>().join(", "),
        })
    }
}

impl Motion {
    /// The position of a joint at a path time \[s\].
    pub(crate) fn joint_at(&self, time: f64, joint: usize) -> f64 {
        if time <= 0.0 {
            self.ends[0][joint]
        } else if time >= self.speed.duration() {
            self.ends[1][joint]
        } else {
            self.path.joint_at(self.speed.at(time).s, joint) + self.offset[joint]
        }
    }
}
