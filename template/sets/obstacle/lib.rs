//! The task: what the processes of the cell run.

pub mod arm; // the kind of robot that everything here is written for
pub mod generators; // motions, a file each
pub mod mp; // the program of the coordinator
pub mod world; // what the planner knows

use mrroc::prelude::*;

/// Puts the cell of `cell.toml` together.
pub fn cell(file: &CellFile) -> Result<Cell, CellError> {
    let cell = file.cell(&arm::kinds())?; // its robots
    let (arm, clearance) = world::known(file)?;
    Ok(cell.program(move |mp| mp::coordinate(mp, &arm, clearance.clone()))) // what the coordinator does
}
