//! The task: what the processes of the cell run.

pub mod arm; // the kind of robot that everything here is written for
pub mod ecp; // the program of the robot: its behaviours
pub mod generators; // motions, a file each
pub mod mp; // the program of the coordinator
pub mod orders; // what the coordinator tells the robot
pub mod touch; // the virtual sensor that behaviours go by

use mrroc::prelude::*;

/// Puts the cell of `cell.toml` together.
pub fn cell(file: &CellFile) -> Result<Cell, CellError> {
    let cell = file.cell(&arm::kinds())?; // its robots
    let cell = cell.sensor(file.sensor("touch", touch::Post)?); // its sensors
    let cell = ecp::programs(cell); // what the robot does
    Ok(cell.program(mp::coordinate)) // what the coordinator does
}
