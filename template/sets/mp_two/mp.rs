//! The coordinator: the task as a sequence of instructions.

use mrroc::prelude::*;

use crate::arm::Arm; // the kind of robots{% if task == "empty" %}
use crate::generators::MyMotion; // how they move{% else %}
use crate::generators::PointToPoint; // how they move{% endif %}{% if sensor == "touch" %}
use crate::touch::{Touch, clear}; // what is sensed{% endif %}

/// FILL IN: the instructions of the task: Move generates the robots' next states, Wait holds until a condition is met.
pub fn coordinate(mp: &mut Mp) -> Result<(), Fault> {
    let mut left = mp.robot::<Arm>("left")?; // named as in cell.toml
    let mut right = mp.robot::<Arm>("right")?; // as well{% if sensor == "touch" %}
    let mut touch = mp.sensor::<Touch>("touch")?; // this too
    mp.wait_until((&mut left,), (&mut touch,), clear {})?; // until the tool is off the table{% endif %}{% if task == "empty" %}
    mp.move_robots((&mut left, &mut right), (), MyMotion::new())?; // holds for a second{% else %}
    mp.move_robots((&mut left, &mut right), (), PointToPoint::by(0.0, 0.0, 0.1))?; // up, in metres
    mp.move_robots((&mut left, &mut right), (), PointToPoint::by(0.0, 0.0, -0.1))?; // and down again{% endif %}
    Ok(())
}
