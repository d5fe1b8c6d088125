//! Two arms at the belt keep clear of each other: a guard, and what a run shows.
//!
//! The guard stops the cell where the arms, with their hands, are nearer than they can come until the cell stands: the largest speed at which
//! they close in on each other in this task, [`CLOSING`], times the path time of a stop, [`STOP`]. `tests/two_arms.rs` measures the first.
//!
//! `Clearance::check` needs no such knowledge; its bound lets every joint of both arms go on in the worst direction, which was 1.2 m where
//! the hands were 1.1 m apart.

use std::cell::Cell as Shown;
use std::rc::Rc;

use mrroc::prelude::*;
use mrroc::robot::RobotView;
use mrroc_robots::Irp6;
use mrroc_robots::clearance::{
    Capsule, CheckError, Clearance, ClearanceError, Nearest, Stop, Stopping, TooClose,
};
use nalgebra::Vector3;

use super::layout::STATIONS;

/// Steps from one look of the guard to the next.
pub const EVERY: u32 = 2;
/// The largest speed at which the arms close in on each other [m/s], and some to spare.
pub const CLOSING: f64 = 0.95;
/// The largest `v/a` of what the arms do \[s\]: what a joint needs to brake.
pub const BRAKING: f64 = 0.45;
/// A step of the cell \[s\].
const STEP: f64 = 4e-3;
/// Path time in which the cell stands \[s\]: the steps from a look to the one after the next, with those that a stop takes to begin, and
/// that of a stop on the path, `1/2c + 1.392 (v/a + step)` with the largest change of the rate `c` = 5/s.
pub const STOP: f64 = (2 * EVERY + 2) as f64 * STEP + 0.5 / 5.0 + 1.392 * (BRAKING + STEP);
/// So near the arms may come \[m\]; what is nearer may touch before the cell stands.
pub const MARGIN: f64 = CLOSING * STOP;
/// The hand with its open fingers: a capsule of this radius along z of the flange, to here \[m\].
const HAND: [f64; 2] = [0.06, 0.2];

/// Both arms of a cell with their hands.
///
/// # Errors
/// A figure of the layout is out of range.
pub fn clearance(file: &CellFile) -> Result<Clearance, Fault> {
    build(file).map_err(|bad| Fault::thrown(&bad.to_string()))
}

fn build(file: &CellFile) -> Result<Clearance, ClearanceError> {
    let [radius, length] = HAND;
    let hand = [Capsule::new(Vector3::zeros(), Vector3::new(0.0, 0.0, length - radius), radius)];
    let mut clearance = Clearance::with_margin(0.0);
    for station in STATIONS {
        let [arm, _] = station.robots;
        let entry = file.robots().iter().find(|robot| robot.name() == arm);
        let base = entry.map_or_else(Pose::identity, |robot| robot.base());
        // Of its own links an arm takes care by itself.
        clearance = clearance.robot(arm, Irp6::nominal().with_base(base))?.tool(arm, &hand)?.ignore_own(arm);
    }
    clearance.build(Stopping { reaction: 0.0, stop: Stop::Braking })
}

/// How near the arms have come by what they were demanded.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Seen {
    /// The least distance \[m\].
    pub least: f64,
    /// The largest speed at which they closed in on each other [m/s].
    pub closing: f64,
}

/// What a guard does that looks in every step: every [`EVERY`]th time it stops the cell where the arms are nearer than `margin` \[m\].
///
/// # Errors
/// As [`clearance`].
pub fn guard(
    file: &CellFile,
    margin: f64,
    seen: Rc<Shown<Seen>>,
) -> Result<impl FnMut(&[RobotView]) -> Result<(), Fault> + use<>, Fault> {
    let mut clearance = clearance(file)?;
    let period = f64::from(EVERY) * file.step().as_secs_f64();
    let (mut left, mut last) = (0, None);
    Ok(move |robots: &[RobotView]| {
        if left > 0 {
            left -= 1;
            return Ok(());
        }
        left = EVERY - 1;
        let nearest = clearance.nearest(robots)?;
        let Seen { least, closing } = seen.get();
        let closer = last.map_or(0.0, |last: f64| (last - nearest.distance) / period);
        last = Some(nearest.distance);
        seen.set(Seen { least: least.min(nearest.distance), closing: closing.max(closer) });
        if nearest.distance < margin {
            return Err(CheckError::from(TooClose(Nearest { travel: margin, margin: 0.0, ..nearest })).into());
        }
        Ok(())
    })
}
