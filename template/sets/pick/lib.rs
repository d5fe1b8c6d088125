//! The task: what the processes of the cell run.

pub mod belt; // what is simulated: the belt, its parts, the camera
pub mod ecp; // the programs of arm and hand
pub mod generators; // how the arm takes a part
pub mod mp; // the program of the coordinator
pub mod orders; // what the coordinator tells them

use mrroc::prelude::*;
use mrroc_sensors::virtual_sensors::Encoder;

/// Puts the cell of `cell.toml` together; `shown` gets what is simulated, for the picture and the test.
pub fn cell(file: &CellFile, shown: &belt::Shown) -> Result<Cell, CellError> {
    let frame = file.robots().iter().find(|robot| robot.name() == "belt").map(|belt| belt.base());
    let frame = frame.unwrap_or_else(Pose::identity); // X_WF
    let line = belt::line(frame)?;
    shown.replace(Some(line.clone()));
    let cell = file.cell(&belt::kinds(line.world()))?; // its robots
    let cell = cell.sensor(file.sensor("camera", belt::camera(line))?); // its sensors
    let cell = cell.sensor(file.sensor("encoder", Encoder)?);
    let cell = cell.ecp("arm", move |ecp| ecp::arm(ecp, frame)).ecp("hand", ecp::hand);
    Ok(cell.program(mp::coordinate))
}
