//! Along a course until a wall is seen in its way.

use mrroc::prelude::*;
use mrroc_wheels::generators::{BaseLimits, Follower};
use mrroc_wheels::sensing::Lookout;
use mrroc_wheels::{Course, DiffDrive};

use crate::places::Sizes;

/// What is measured is so many steps behind what is demanded.
const DELAY: f64 = 1.5;

/// Follows a course by where the base stands, or until its way is blocked.
pub struct Leg {
    follower: Follower,
    /// How many ways had been blocked before.
    before: u32,
}

impl Leg {
    /// Along `course`; `before` ways were blocked until now.
    #[must_use]
    pub fn along(course: Course, sizes: &Sizes, before: u32) -> Self {
        let limits =
            BaseLimits { speed: sizes.velocity, lateral: sizes.acceleration, turning: 6.0, off: 0.05 };
        Self { follower: Follower::on(course, limits, DELAY), before }
    }
}

#[generator(ecp)]
impl Leg {
    fn first_step(
        &mut self,
        e: &State<DiffDrive>,
        v: &Reading<(Lookout,)>,
        t: Tick,
    ) -> Result<Step<DiffDrive>, Fault> {
        self.follower.begin(e.demanded().joints)?;
        self.next_step(v, t)
    }

    fn next_step(&mut self, v: &Reading<(Lookout,)>, t: Tick) -> Result<Step<DiffDrive>, Fault> {
        let sight = v.0.reading().ok_or_else(|| Fault::thrown("it is not known where the base stands"))?;
        if sight.blocked != self.before {
            return Ok(Step::Done);
        }
        Ok(match self.follower.advance(Some(&sight.pose), t.dt)? {
            Some(wheels) => Step::Next(Demand::joints(wheels)),
            None => Step::Done,
        })
    }
}
