//! The arms keep clear of each other and of the table: a guard, and what a dry run of the whole program shows.
//!
//! The guard asks for a distance where the arms are, not where they would stand after a stop: a stop is on the path, which the
//! dry run has shown to be clear. The bound of [`Clearance::check`], which knows no path, is far too large for arms with up
//! to seven joints that work a hand's breadth from one another: it allows every joint to turn on in the worst way.

use mrroc::{CellFile, Fault, Pose, RobotView};
use mrroc_robots::clearance::{
    Capsule, CheckError, Clearance, ClearanceError, Nearest, Obstacle, Stop, Stopping, TooClose,
};
use mrroc_robots::{Polycrank, Rnt};
use nalgebra::Vector3;

use crate::places::{TABLE_EDGES, table};

/// How near arms may come to each other and to the table \[m\]; the hands work at the table.
pub const MARGIN: f64 = 0.05;

/// Steps from one look of the guard to the next.
pub const EVERY: u32 = 10;

/// Both arms of a cell with their hands, and the table.
///
/// # Errors
/// A figure of `places.rs` is out of range.
pub fn clearance(file: &CellFile) -> Result<Clearance, Fault> {
    build(file).map_err(|bad| Fault::thrown(&bad.to_string()))
}

fn build(file: &CellFile) -> Result<Clearance, ClearanceError> {
    let base = |name: &str| {
        let robot = file.robots().iter().find(|robot| robot.name() == name);
        robot.map_or_else(Pose::identity, |robot| robot.base())
    };
    // From the flange to the fingertips.
    let hand = [Capsule::new(Vector3::new(0.0, 0.0, 0.02), Vector3::new(0.0, 0.0, 0.13), 0.03)];
    let half = Vector3::from(TABLE_EDGES) * 0.5;
    let mut clearance = Clearance::with_margin(MARGIN)
        .robot("rnt", Rnt::new().with_base(base("rnt")))?
        .robot("polycrank", Polycrank::new().with_base(base("polycrank")))?
        .obstacle("table", Obstacle::Box { X_WO: table(), half })?;
    for arm in ["rnt", "polycrank"] {
        clearance = clearance.tool(arm, &hand)?.ignore((arm, "tool"), ("table", "table"));
    }
    clearance.build(Stopping { reaction: 0.0, stop: Stop::Braking })
}

/// What a guard does with a clearance: stops the cell where two bodies are nearer than the margin.
pub fn guard(mut clearance: Clearance, margin: f64) -> impl FnMut(&[RobotView]) -> Result<(), Fault> {
    move |robots| {
        let nearest = clearance.nearest(robots)?;
        if nearest.distance < margin {
            return Err(CheckError::from(TooClose(Nearest { margin, ..nearest })).into());
        }
        Ok(())
    }
}
