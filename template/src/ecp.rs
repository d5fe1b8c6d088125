//! The robot: what it does in each phase that the coordinator orders.

use mrroc::prelude::*;

use crate::arm::Arm; // the kind of robot{% if task == "empty" %}
use crate::generators::MyMotion; // how it moves{% else %}
use crate::generators::PointToPoint; // how it moves{% endif %}
use crate::orders::Phase; // what it is told

/// Gives the robot its program.
pub fn programs(cell: Cell) -> Cell {
    cell.ecp("arm", arm) // named as in cell.toml
}

fn arm(ecp: &mut Ecp<Arm>) -> Result<(), Fault> {
    ecp.serve_all(|ecp, phase: Phase| match phase {
        Phase::Out => out(ecp),
        Phase::Back => back(ecp),
    })
}

/// FILL IN: the instructions of this phase; Move generates the robot's next state step by step.
fn out(ecp: &mut Ecp<Arm>) -> Result<(), Fault> {
    // Returning means finished.{% if task == "empty" %}
    ecp.move_robot((), MyMotion::new())?; // holds for a second{% else %}
    ecp.move_robot((), PointToPoint::by(0.0, 0.0, 0.1))?; // up, in metres{% endif %}
    Ok(())
}

/// FILL IN: the instructions of this phase.
fn back(ecp: &mut Ecp<Arm>) -> Result<(), Fault> {
    // Returning means finished.{% if task == "empty" %}
    ecp.move_robot((), MyMotion::new())?; // holds for a second{% else %}
    ecp.move_robot((), PointToPoint::by(0.0, 0.0, -0.1))?; // down again{% endif %}
    Ok(())
}
