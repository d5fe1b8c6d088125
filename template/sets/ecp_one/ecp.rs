//! The robot: its task as a sequence of instructions.

use mrroc::prelude::*;

use crate::arm::Arm; // the kind of robot{% if task == "empty" %}
use crate::generators::MyMotion; // how it moves{% else %}
use crate::generators::PointToPoint; // how it moves{% endif %}{% if sensor == "touch" %}
use crate::touch::{Touch, open}; // what it senses{% endif %}

/// Gives the robot its program.
pub fn programs(cell: Cell) -> Cell {
    cell.ecp("arm", arm) // named as in cell.toml
}

/// FILL IN: the instructions of the task, one after another.
fn arm(ecp: &mut Ecp<Arm>) -> Result<(), Fault> {
    // Move generates the robot's next state step by step, Wait holds until a condition is met.{% if sensor == "touch" %}
    let mut touch = ecp.sensor::<Touch>("touch")?; // named as in cell.toml
    ecp.wait_until((&mut touch,), open {})?; // until the tool is off the table{% endif %}{% if task == "empty" %}
    ecp.move_robot((), MyMotion::new())?; // holds for a second{% else %}
    ecp.move_robot((), PointToPoint::by(0.0, 0.0, 0.1))?; // up, in metres
    ecp.move_robot((), PointToPoint::by(0.0, 0.0, -0.1))?; // and down again{% endif %}
    Ok(())
}
