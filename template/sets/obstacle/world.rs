//! What the planner knows: the shape of the arm, and the obstacles of cell.toml.

use mrroc::cell_file::EntryKey;
use mrroc::prelude::*;
use mrroc_robots::clearance::{Clearance, ClearanceError, Stopping};
use mrroc_robots::{SerialOutline, urdf_arm};

use crate::arm::Arm;

/// FILL IN: how near the arm may come to anything [m]; it covers what shapes and drives are off.
pub const MARGIN: f64 = 0.02;
/// FILL IN: how thick its links are [m]; a URDF with `<collision>` shapes has them (`SerialOutline::from_urdf`).
const RADIUS: f64 = 0.06;

/// The arm, and what is around it.
pub fn known(file: &CellFile) -> Result<(Arm, Clearance), CellError> {
    let entry = file.robots().iter().find(|robot| robot.name() == "arm");
    let entry = entry.ok_or_else(|| CellError::NoRobot("arm".to_owned(), "no arm".to_owned()))?;
    let arm: Arm = urdf_arm(entry)?;
    match clearance(arm.clone(), file) {
        Ok(clearance) => Ok((arm, clearance)),
        Err(ClearanceError::File(why)) => Err(why), // it names the line of cell.toml
        Err(why) => Err(entry.refuse(EntryKey::File, why.to_string(), "correct src/world.rs".to_owned())),
    }
}

fn clearance(arm: Arm, file: &CellFile) -> Result<Clearance, ClearanceError> {
    Clearance::with_margin(MARGIN)
        .robot("arm", SerialOutline::new(arm, RADIUS))?
        .obstacles(file)?
        .ignore(("arm", "link 0"), ("table", "table")) // the arm stands on it
        .build(Stopping::of_guard(file.step(), 1))
}
