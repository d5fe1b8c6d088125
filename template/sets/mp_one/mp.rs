//! The coordinator: the task as a sequence of instructions.

use mrroc::prelude::*;

use crate::arm::Arm; // the kind of robot{% if task == "empty" %}
use crate::generators::MyMotion; // how it moves{% else %}
use crate::generators::PointToPoint; // how it moves{% endif %}{% if sensor == "touch" %}
use crate::touch::{Touch, clear}; // what is sensed{% endif %}

/// FILL IN: the instructions of the task: Move generates the robots' next states, Wait holds until a condition is met.
pub fn coordinate(mp: &mut Mp) -> Result<(), Fault> {
    let mut arm = mp.robot::<Arm>("arm")?; // named as in cell.toml{% if sensor == "touch" %}
    let mut touch = mp.sensor::<Touch>("touch")?; // as well
    mp.wait_until((&mut arm,), (&mut touch,), clear {})?; // until the tool is off the table{% endif %}{% if task == "empty" %}
    mp.move_robots((&mut arm,), (), MyMotion::new())?; // holds for a second{% else %}
    mp.move_robots((&mut arm,), (), PointToPoint::by(0.0, 0.0, 0.1))?; // up, in metres
    mp.move_robots((&mut arm,), (), PointToPoint::by(0.0, 0.0, -0.1))?; // and down again{% endif %}
    Ok(())
}
