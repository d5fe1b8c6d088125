//! The arms keep clear of each other and of the table: a guard, and what a dry run of the whole program shows.
//!
//! The guard stops the cell where two bodies are nearer than they can come until the cell stands: the largest speed of a link
//! of the task times the time of a stop, [`STOP`]. Both are figures of this task, which `tests/clear.rs` measures:
//!
//! - Between the arms count the largest speeds of a link of each, [`FASTEST`], as if both went straight at each other.
//!   They are not those of the tools: in the leg over, Polycrank's first cranks go farther than what they carry.
//! - To the table counts how fast a link comes down on it, [`SINKING`]. It covers links above the table, not one that would go
//!   sideways into its edge, up to 0.18 m/s fast: in the dry run none comes nearer than 86 mm to any side.
//!
//! Hands work at the table and are not held off it; a bar that is carried is no body of the clearance.
//!
//! [`Clearance::check`] needs no such knowledge of the path; its bound allows every joint to turn on in the worst direction, which
//! is too large for arms of up to seven joints that work so near to one another: 1.6 m where these are 0.3 m apart.

use mrroc::prelude::*;
use mrroc::robot::RobotView;
use mrroc_robots::clearance::{
    Capsule, CheckError, Clearance, ClearanceError, Nearest, Obstacle, Stop, Stopping, TooClose,
};
use mrroc_robots::{Polycrank, Rnt};
use nalgebra::Vector3;

use crate::places::{TABLE_EDGES, table};

/// Steps from one look of the guard to the next.
pub const EVERY: u32 = 10;

/// How near the arms may come \[m\], each > 0: what is nearer may touch before the cell stands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Margins {
    /// To each other.
    pub arms: f64,
    /// To the table, but for the hands, which work at it.
    pub table: f64,
}

/// The largest speed of a link of RNT and of Polycrank [m/s]: 0.105 m/s and 0.180 m/s in the runs, and some to spare.
pub const FASTEST: [f64; 2] = [0.11, 0.185];

/// The largest speed at which a link comes down [m/s]: that of straight motions down, `limits()`, and some to spare.
pub const SINKING: f64 = 0.102;

/// The largest `v/a` of a joint of the arms \[s\]: what it needs to brake.
pub const BRAKING: f64 = 0.42;

/// Path time in which the cell stands \[s\]: 22 steps from a look to the one after the next, with those that a stop takes to
/// begin, 44 ms; and that of a stop, `1/2c + 1.392 (v/a + step)` with the largest change of the rate `c` = 5/s.
pub const STOP: f64 = (2 * EVERY + 2) as f64 * 2e-3 + 0.5 / 5.0 + 1.392 * (BRAKING + 2e-3);

/// Those of the task: 0.216 m and 0.075 m.
pub const MARGINS: Margins = Margins { arms: (FASTEST[0] + FASTEST[1]) * STOP, table: SINKING * STOP };

/// What is around the arms.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Around {
    /// They see each other alone.
    Nothing,
    /// They see the table, too.
    Table,
}

/// Both arms of a cell with their hands, and what is around them.
///
/// # Errors
/// A figure of `places.rs` is out of range.
pub fn clearance(file: &CellFile, around: Around) -> Result<Clearance, Fault> {
    build(file, around).map_err(|bad| Fault::thrown(&bad.to_string()))
}

fn build(file: &CellFile, around: Around) -> Result<Clearance, ClearanceError> {
    let base = |name: &str| {
        let robot = file.robots().iter().find(|robot| robot.name() == name);
        robot.map_or_else(Pose::identity, |robot| robot.base())
    };
    // From the flange to the fingertips.
    let hand = [Capsule::new(Vector3::new(0.0, 0.0, 0.02), Vector3::new(0.0, 0.0, 0.13), 0.03)];
    let mut clearance = Clearance::with_margin(0.0)
        .robot("rnt", Rnt::new().with_base(base("rnt")))?
        .robot("polycrank", Polycrank::new().with_base(base("polycrank")))?
        .tool("rnt", &hand)?
        .tool("polycrank", &hand)?;
    if around == Around::Table {
        let half = Vector3::from(TABLE_EDGES) * 0.5;
        clearance = clearance.obstacle("table", Obstacle::Box { X_WO: table(), half })?;
        for arm in ["rnt", "polycrank"] {
            clearance = clearance.ignore((arm, "tool"), ("table", "table"));
        }
    }
    clearance.build(Stopping { reaction: 0.0, stop: Stop::Braking })
}

/// What a guard does: it looks at the distance to the other arm and to the table by turns, and stops the cell where an arm
/// is nearer than it may be.
///
/// # Errors
/// As [`clearance`].
pub fn guard(
    file: &CellFile,
    margins: Margins,
) -> Result<impl FnMut(&[RobotView]) -> Result<(), Fault> + use<>, Fault> {
    let arms = (clearance(file, Around::Nothing)?, margins.arms);
    let table = (clearance(file, Around::Table)?, margins.table);
    let mut looks = [arms, table];
    Ok(move |robots: &[RobotView]| {
        looks.swap(0, 1);
        let (clearance, margin) = &mut looks[0];
        keep(clearance.nearest(robots)?, *margin)
    })
}

/// Refuses what is nearer than `travel` \[m\], by which it may still come nearer until the cell stands.
fn keep(nearest: Nearest, travel: f64) -> Result<(), Fault> {
    if nearest.distance < travel {
        return Err(CheckError::from(TooClose(Nearest { travel, margin: 0.0, ..nearest })).into());
    }
    Ok(())
}
