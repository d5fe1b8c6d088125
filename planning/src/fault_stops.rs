//! What fault stops sweep from a stretch of a plan, in a world that has changed since it was planned.
//!
//! In: a stretch of a plan that is followed. Out: [`FaultStops`], a [`KnownPath`] of each robot by the share of its stop, 0 to 1, so that a guard can
//! prove it against one obstacle. The set is that of [`Swept`](crate::stop::Swept), which the planner has proven: in it the robots go on for the
//! reaction time and brake by their braking law. The pair of a link and an obstacle does not depend on other robots, so one share for all of them
//! takes all that they do apart. It allocates nothing.

// As in `guard.rs`: errors are told within a step.
#![allow(clippy::result_large_err)]

use mrroc::robot::MAX_JOINTS;
use mrroc_robots::clearance::{Against, CheckError, Clearance, KnownPath, Stretch};

use crate::followed::Followed;
use crate::reach::{Reach, reaches};
use crate::stop::ROBOTS;

/// The widest stretch of a path, and the narrowest that is halved [rad or m].
const WIDEST: f64 = 0.05;
const NARROWEST: f64 = 1e-5;
/// The most parts of them that are looked at before the stretch is halved.
const PARTS: f64 = 400.0;

/// The fault stops from a stretch of a plan.
pub(crate) struct FaultStops {
    /// Where the stretch ends.
    end: f64,
    robots: [Stretch; ROBOTS],
    /// Where each joint may be in a stop, as seen from there.
    reach: [[Reach; MAX_JOINTS]; ROBOTS],
}

impl FaultStops {
    /// From the parameters `from` to `to` of a plan, or sooner.
    fn new(followed: &Followed, from: f64, to: f64) -> Self {
        let mut robots = [Stretch::default(); ROBOTS];
        let end = followed.stretch(from, to, &mut robots);
        let (limits, reaction) = (followed.limits(), followed.reaction());
        let speed = followed.fastest_between(from, end);
        let mut rates = [[[0.0; 2]; MAX_JOINTS]; ROBOTS];
        let mut reach = [[Reach::default(); MAX_JOINTS]; ROBOTS];
        followed.rates(from, end + speed * reaction, |robot, i, of| {
            rates[robot][i] = of.map(|rate| rate * speed)
        });
        for (robot, joints) in followed.joints().enumerate() {
            let first = joints.start;
            let rates = |j: usize| rates[robot][j - first];
            reaches(limits, joints, reaction, rates, |j, of| reach[robot][j - first] = of);
        }
        FaultStops { end, robots, reach }
    }

    /// Into how many parts the stops are cut at most, with those that are cut: in shorter ones, what the stretch itself takes is larger.
    fn parts(&self) -> u32 {
        let longest = self.reach.iter().flatten().map(|reach| reach.travel().abs()).fold(0.0, f64::max);
        let widest = self.robots.iter().flat_map(|robot| robot.half).fold(NARROWEST, f64::max);
        (4.0 + 2.0 * longest / widest).min(PARTS) as u32
    }
}

impl KnownPath for FaultStops {
    fn stretch(&self, from: f64, to: f64, robots: &mut [Stretch]) -> f64 {
        for (stretch, (own, reach)) in robots.iter_mut().zip(self.robots.iter().zip(&self.reach)) {
            *stretch = *own;
            for (i, reach) in reach.iter().enumerate() {
                let [lower, upper] = reach.between(from, to);
                stretch.middle[i] += 0.5 * (lower + upper);
                stretch.half[i] += 0.5 * (upper - lower);
            }
        }
        to
    }
}

/// How far fault stops are proven.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Proof {
    /// Up to this parameter of a plan.
    pub(crate) proven: f64,
    /// How wide a stretch is tried next [rad or m].
    pub(crate) width: f64,
}

impl Proof {
    /// What the planner has proven needs no proof.
    pub(crate) const NOT_NEEDED: Proof = Proof { proven: f64::INFINITY, width: WIDEST };
    /// All is to be proven.
    pub(crate) const NOTHING: Proof = Proof { proven: 0.0, width: WIDEST };

    /// Proves that fault stops from everywhere on a plan to the parameter `to` keep the margins of an obstacle. It looks at no more than `parts` boxes,
    /// which it counts down. What is not proven when they are spent is told.
    pub(crate) fn extend(
        &mut self,
        clearance: &mut Clearance,
        followed: &Followed,
        to: f64,
        against: Against,
        parts: &mut u32,
    ) -> Result<Option<CheckError>, CheckError> {
        let mut failed = None;
        while self.proven < to {
            let stops = FaultStops::new(followed, self.proven, to.min(self.proven + self.width));
            let own = stops.parts().min(*parts);
            let mut left = own;
            let result = clearance.prove(&stops, &mut 0.0, 1.0, against, &mut left);
            *parts -= own - left;
            match result {
                Ok(()) => {
                    self.proven = stops.end;
                    self.width = WIDEST.min(1.4 * self.width);
                }
                Err(error) => {
                    self.width = 0.5 * (stops.end - self.proven);
                    if self.width < NARROWEST {
                        self.width = WIDEST;
                        return Err(error);
                    }
                    failed = Some(error);
                }
            }
            if *parts == 0 && self.proven < to {
                return Ok(failed);
            }
        }
        Ok(None)
    }
}
