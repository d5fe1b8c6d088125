//! A plan: a motion of all joints over path time, and how near it comes to what is around.

use std::sync::Arc;

use mrroc::fault::Name;
use mrroc_robots::clearance::{CheckError, Clearance, Nearest};

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

/// What robots do where they are nearest to something.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum During {
    /// They follow the plan; a stop on the path does so too.
    Motion,
    /// All of them stop by a fault, each on its own line.
    FaultStop,
}

/// The nearest that robots come to something, and when.
#[derive(Clone, Debug, PartialEq)]
pub struct Closest {
    /// Path time from the beginning of the motion \[s\]: of a stop, when it begins.
    pub time: f64,
    /// What they do then.
    pub during: During,
    /// Both bodies and their distance.
    pub nearest: Nearest,
}

impl core::fmt::Display for Closest {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let during = match self.during {
            During::Motion => "in the motion, at",
            During::FaultStop => "in a fault stop that begins at",
        };
        write!(f, "{} {during} {:.3} s", self.nearest, self.time)
    }
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

    /// The smallest clearance of the motion and that of its fault stops, looked at every `step` \[s\], > 0: at the instants of the motion, and
    /// at four places of the stop of all robots that begins at each of them.
    ///
    /// # Errors
    /// [`PlanError::Check`]: the clearance is of other robots.
    pub fn closest(&self, clearance: &mut Clearance, step: f64) -> Result<[Closest; 2], PlanError> {
        let count = (self.duration() / step).ceil().max(1.0) as usize;
        let mut motion: Option<Closest> = None;
        let mut stops: Option<Closest> = None;
        for k in 0..=count {
            let time = k as f64 * step;
            let q = self.at(time);
            self.keep(clearance, &mut motion, time, During::Motion, &q)?;
            let travel = self.stopping(time);
            for quarter in 1..=4 {
                let share = 0.25 * f64::from(quarter);
                let stopped: Vec<f64> = q.iter().zip(&travel).map(|(q, travel)| q + share * travel).collect();
                self.keep(clearance, &mut stops, time, During::FaultStop, &stopped)?;
            }
        }
        match (motion, stops) {
            (Some(motion), Some(stops)) => Ok([motion, stops]),
            (None, _) | (_, None) => Err(CheckError::NothingToCheck.into()),
        }
    }

    fn keep(
        &self,
        clearance: &mut Clearance,
        closest: &mut Option<Closest>,
        time: f64,
        during: During,
        q: &[f64],
    ) -> Result<(), PlanError> {
        let nearest = clearance.nearest_at(&self.motion.limits.split(q))?;
        if closest.as_ref().is_none_or(|closest| nearest.distance < closest.nearest.distance) {
            *closest = Some(Closest { time, during, nearest });
        }
        Ok(())
    }

    /// How far each joint goes in a fault stop that begins at a path time, from where it is then [rad or m].
    fn stopping(&self, time: f64) -> Vec<f64> {
        let Motion { path, speed, limits, .. } = &*self.motion;
        let at = speed.at(time.clamp(0.0, speed.duration()));
        let point = path.at(at.s);
        let velocity: Vec<f64> = point.first.iter().map(|first| first * at.v).collect();
        let mut travel = vec![0.0; velocity.len()];
        for robot in &limits.robots {
            let slowest =
                robot.clone().map(|j| velocity[j].abs() / limits.acceleration[j]).fold(0.0, f64::max);
            for j in robot.clone() {
                // With a limit of jerk each joint stops by itself, from a steady speed in `v/a + a/j` at half of it.
                let alone = limits.jerk[j].map(|jerk| {
                    let a = limits.acceleration[j];
                    velocity[j].abs() / a + a / jerk
                });
                travel[j] = 0.5 * velocity[j] * alone.unwrap_or(slowest);
            }
        }
        travel
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
