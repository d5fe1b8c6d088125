//! The robots: what each does in each phase that the coordinator orders.

use mrroc::prelude::*;

use crate::arm::Arm; // the kind of robots{% if task == "empty" %}
use crate::generators::MyMotion; // how they move{% else %}
use crate::generators::PointToPoint; // how they move{% endif %}
use crate::orders::Phase; // what they are told

/// Gives each robot its program.
pub fn programs(cell: Cell) -> Cell {
    cell.ecp("left", left).ecp("right", right) // named as in cell.toml
}

fn left(ecp: &mut Ecp<Arm>) -> Result<(), Fault> {
    ecp.serve_all(|ecp, phase: Phase| match phase {
        Phase::Out => left_out(ecp),
        Phase::Back => left_back(ecp),
    })
}

fn right(ecp: &mut Ecp<Arm>) -> Result<(), Fault> {
    ecp.serve_all(|ecp, phase: Phase| match phase {
        Phase::Out => right_out(ecp),
        Phase::Back => right_back(ecp),
    })
}

/// FILL IN: the instructions of this phase; Move generates the robot's next state step by step.
fn left_out(ecp: &mut Ecp<Arm>) -> Result<(), Fault> {
    // Returning means finished.{% if task == "empty" %}
    ecp.move_robot((), MyMotion::new())?; // holds for a second{% else %}
    ecp.move_robot((), PointToPoint::by(0.0, 0.0, 0.1))?; // up, in metres{% endif %}
    Ok(())
}

/// FILL IN: the instructions of this phase.
fn left_back(ecp: &mut Ecp<Arm>) -> Result<(), Fault> {
    // Returning means finished.{% if task == "empty" %}
    ecp.move_robot((), MyMotion::new())?; // holds for a second{% else %}
    ecp.move_robot((), PointToPoint::by(0.0, 0.0, -0.1))?; // down again{% endif %}
    Ok(())
}

/// FILL IN: the instructions of this phase; the robot that finishes first holds until the other has finished, too.
fn right_out(ecp: &mut Ecp<Arm>) -> Result<(), Fault> {
    // Returning means finished.{% if task == "empty" %}
    ecp.move_robot((), MyMotion::new())?; // holds for a second{% else %}
    ecp.move_robot((), PointToPoint::by(-0.05, 0.0, 0.05))?; // towards its base and up{% endif %}
    Ok(())
}

/// FILL IN: the instructions of this phase.
fn right_back(ecp: &mut Ecp<Arm>) -> Result<(), Fault> {
    // Returning means finished.{% if task == "empty" %}
    ecp.move_robot((), MyMotion::new())?; // holds for a second{% else %}
    ecp.move_robot((), PointToPoint::by(0.05, 0.0, -0.05))?; // and back{% endif %}
    Ok(())
}
