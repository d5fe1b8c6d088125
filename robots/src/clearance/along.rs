//! Whether robots that follow a known path keep their margins on a stretch of it.
//!
//! In: a [`KnownPath`] of all robots together. Out: up to where all pairs are proven to keep their margins, in all that the joints pass.
//!
//! A stretch is taken as a box: where the joints are in its middle, and by how much each may be off that. From there the bound of the
//! [module](super) holds, with these distances instead of those of a stop. Where a pair is not proven, the stretch is halved; where
//! the middle itself is too near, there is nothing to halve. Short stretches are proven wherever the distance is more than the margin, because the
//! bound shrinks with them. What is proven needs no second proof.

use super::check::Clearance;
use super::error::{CheckError, Nearest, TooClose};
use super::pairs::{Group, Partner};
use super::posture::Stretch;
use super::search::Purpose;

/// A stretch that is shorter than this share of what is asked for, and not proven, counts as too near.
const SHORTEST: f64 = 1e-9;

/// A path that the robots of a clearance follow together, by a parameter that rises.
pub trait KnownPath {
    /// Where the robots are, in the order of the clearance, from the parameter `from` to `to`, or to a lower one above `from`: gives where
    /// the stretch ends.
    fn stretch(&self, from: f64, to: f64, robots: &mut [Stretch]) -> f64;
}

/// Which pairs are proven.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Against {
    /// All of them.
    Everything,
    /// Robots and the obstacle of this number.
    Obstacle(usize),
    /// Links and what robots carry, among themselves.
    Links,
}

impl Against {
    pub(super) fn takes(self, group: &Group) -> bool {
        match (self, group.other) {
            (Against::Everything, _) | (Against::Links, Partner::Part(_)) => true,
            (Against::Obstacle(wanted), Partner::Obstacle(obstacle)) => wanted == obstacle,
            (Against::Obstacle(_), Partner::Part(_)) | (Against::Links, Partner::Obstacle(_)) => false,
        }
    }
}

impl Clearance {
    /// Proves that pairs keep their margins everywhere on a path from the parameter `proven` to `to`, both of them included, and moves `proven` to
    /// where that holds. It looks at no more than `parts` stretches, which it counts down. It allocates nothing. The robots stand
    /// somewhere on the path then.
    ///
    /// # Errors
    /// [`CheckError::TooClose`]: at `proven`, or soon behind it, a margin is not kept, or all parts are spent. Told are the distance in the middle of
    /// a stretch and how much nearer its ends may be. [`CheckError::NoPosture`].
    pub fn prove(
        &mut self,
        path: &impl KnownPath,
        proven: &mut f64,
        to: f64,
        against: Against,
        parts: &mut u32,
    ) -> Result<(), CheckError> {
        let all = to - *proven;
        let (mut width, mut was_proven) = (all, true);
        while *proven < to {
            let asked = if *proven + width >= to { to } else { *proven + width };
            let end = path.stretch(*proven, asked, &mut self.stretches);
            for (robot, stretch) in self.robots.iter_mut().zip(&self.stretches) {
                let name = robot.name;
                if !robot.stand(&stretch.middle, Some(&stretch.half)) {
                    return Err(CheckError::NoPosture { robot: name });
                }
            }
            *parts = parts.saturating_sub(1);
            match self.unproven(against) {
                None => {
                    *proven = end;
                    // What was halved is two such parts long.
                    width = if was_proven { 2.0 * width } else { width };
                    was_proven = !was_proven;
                }
                Some(nearest) => {
                    (width, was_proven) = (0.5 * (end - *proven), false);
                    if nearest.distance < nearest.margin || *parts == 0 || width < SHORTEST * all {
                        return Err(TooClose(nearest).into());
                    }
                }
            }
        }
        Ok(())
    }

    /// The pair of these that is farthest from being proven, if any is not.
    fn unproven(&mut self, against: Against) -> Option<Nearest> {
        self.least(Purpose::Slack, |group| against.takes(group), 0.0)
    }
}
