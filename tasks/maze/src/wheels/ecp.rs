//! The base's program: what it does in each task. It knows no maze.

use mrroc::prelude::*;
use mrroc_wheels::generators::BaseLimits;
use mrroc_wheels::model::angle;
use mrroc_wheels::sensing::{Lookout, Watch};
use mrroc_wheels::{DiffDrive, FollowPath, Path};
use nalgebra::Vector2;

use crate::orders::Task;
use crate::places::Sizes;

/// It goes no farther at a time \[m\]: the coordinator looks at what was seen.
const FARTHEST: f64 = 0.72;
/// It is turned towards its path by no less \[rad\], and goes no shorter distance \[m\].
const LEAST: (f64, f64) = (0.008, 5e-4);

/// What is measured is so many steps behind what is demanded ..
const DELAY: f64 = 1.5;
/// .. and may be so many steps old.
const OLDEST: u32 = 2;

/// The base stands, and knows where.
#[condition(ecp)]
fn stands(v: &Reading<(Lookout,)>) -> bool {
    v.0.reading().is_some_and(|sight| sight.stands)
}

/// Along a path by where the base stands, or until its way is blocked.
fn leg(path: Path, sizes: &Sizes) -> FollowPath<Lookout> {
    let limits = BaseLimits { speed: sizes.velocity, lateral: sizes.acceleration, turning: 6.0, off: 0.05 };
    FollowPath::<Lookout>::along(path, limits, |sight| Some(sight.pose), DELAY, OLDEST)
        .until(|sight| sight.is_blocked)
}

/// The base: turned towards where it is told to go, and straight on until a wall is in its way.
///
/// # Errors
/// The first fault of the cell.
pub fn base(ecp: &mut Ecp<DiffDrive>, sizes: &Sizes) -> Result<(), Fault> {
    let mut lookout = ecp.sensor::<Lookout>("lookout")?;
    let mut paths = 0;
    ecp.serve_all(|ecp, task| {
        let Task::Go { x, y } = task else {
            return Err(Fault::thrown("a base with wheels cannot hop over walls"));
        };
        lookout.configure(Watch::default());
        ecp.wait_until((&mut lookout,), stands {})?;
        let sight = lookout.reading().unwrap_or_default();
        let towards = Vector2::new(x, y) - sight.pose.at();
        if towards.norm() < LEAST.1 {
            return Ok(());
        }
        let turn = angle(towards.y.atan2(towards.x) - sight.pose.heading);
        if turn.abs() > LEAST.0 {
            ecp.move_robot((&mut lookout,), leg(Path::turn(sight.pose, turn), sizes))?;
        }
        paths += 1;
        lookout.configure(Watch { path: paths, x, y });
        let from = lookout.reading().unwrap_or_default().pose.at();
        let towards = Vector2::new(x, y) - from;
        let path = Path::through(&[from, from + towards.cap_magnitude(FARTHEST)], 0.01);
        let path = path.map_err(|error| Fault::thrown(&error.to_string()))?;
        ecp.move_robot((&mut lookout,), leg(path, sizes)).map(drop)
    })
}
