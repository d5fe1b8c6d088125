//! The robots: the task of each as a sequence of instructions.

use mrroc::prelude::*;

use crate::arm::Arm; // the kind of robots{% if task == "empty" %}
use crate::generators::MyMotion; // how they move{% else %}
use crate::generators::PointToPoint; // how they move{% endif %}{% if sensor == "touch" %}
use crate::touch::{Touch, open}; // what the left one senses{% endif %}

/// Gives each robot its program.
pub fn programs(cell: Cell) -> Cell {
    cell.ecp("left", left).ecp("right", right) // named as in cell.toml
}

/// FILL IN: the instructions of the left robot, one after another.
fn left(ecp: &mut Ecp<Arm>) -> Result<(), Fault> {
    // Move generates the robot's next state step by step, Wait holds until a condition is met.{% if sensor == "touch" %}
    let mut touch = ecp.sensor::<Touch>("touch")?; // named as in cell.toml
    ecp.wait_until((&mut touch,), open {})?; // until the tool is off the table{% endif %}{% if task == "empty" %}
    ecp.move_robot((), MyMotion::new())?; // holds for a second{% else %}
    ecp.move_robot((), PointToPoint::by(0.0, 0.0, 0.1))?; // up, in metres
    ecp.move_robot((), PointToPoint::by(0.0, 0.0, -0.1))?; // and down again{% endif %}
    Ok(())
}

/// FILL IN: those of the right one, which does not wait for the left one.
fn right(ecp: &mut Ecp<Arm>) -> Result<(), Fault> {
    // Returning means finished.{% if task == "empty" %}
    ecp.move_robot((), MyMotion::new())?; // holds for a second{% else %}
    ecp.move_robot((), PointToPoint::by(-0.05, 0.0, 0.05))?; // towards its base and up
    ecp.move_robot((), PointToPoint::by(0.05, 0.0, -0.05))?; // and back{% endif %}
    Ok(())
}
