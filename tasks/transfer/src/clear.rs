//! The arms keep clear of each other and of the table: a guard, and what a dry run of the whole program shows.
//!
//! The guard stops the cell where two bodies are nearer than a tool goes until it stands, which follows from how fast the task
//! lets tools go: 22 steps from a look to the one after the next, with those that a stop takes to begin, 44 ms, and then the
//! path time of a stop, `1/2c + 1.39 max(v_i/a_i)` with the largest change of the rate `c` = 5/s and joints that need 0.4 s to
//! brake: 0.7 s and 70 mm at 0.1 m/s; twice that for two arms that go towards each other.
//!
//! [`Clearance::check`] needs no such knowledge of the path; its bound allows every joint to turn on in the worst way, which
//! is too large for arms of up to seven joints that work so near to one another: 1.6 m where these are 0.3 m apart.

use mrroc::{CellFile, Fault, Pose, RobotView};
use mrroc_robots::clearance::{
    Capsule, CheckError, Clearance, ClearanceError, Nearest, Obstacle, Stop, Stopping, TooClose,
};
use mrroc_robots::{Polycrank, Rnt};
use nalgebra::Vector3;

use crate::places::{TABLE_EDGES, table};

/// Steps from one look of the guard to the next.
pub const EVERY: u32 = 10;

/// How near the arms may come \[m\], each > 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Margins {
    /// To each other.
    pub arms: f64,
    /// To the table, but for the hands, which work at it.
    pub table: f64,
}

/// Those of the task.
pub const MARGINS: Margins = Margins { arms: 0.144, table: 0.072 };

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

/// What a guard does: stops the cell where an arm is nearer to the other or to the table than it may be, of which it looks
/// at one by turns.
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

/// Refuses what is nearer than `margin` \[m\].
fn keep(nearest: Nearest, margin: f64) -> Result<(), Fault> {
    if nearest.distance < margin {
        return Err(CheckError::from(TooClose(Nearest { margin, ..nearest })).into());
    }
    Ok(())
}
