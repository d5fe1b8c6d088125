//! The coordinator: the task as a sequence of instructions.

use mrroc::prelude::*;

use crate::arm::Arm; // the kind of robot
use crate::orders::Phase; // what it is told{% if sensor == "touch" %}
use crate::touch::{Touch, clear}; // what is sensed{% endif %}

/// FILL IN: the phases in the order in which the task needs them.
pub fn coordinate(mp: &mut Mp) -> Result<(), Fault> {
    let mut arm = mp.robot::<Arm>("arm")?; // named as in cell.toml{% if sensor == "touch" %}
    let mut touch = mp.sensor::<Touch>("touch")?; // as well
    mp.wait_until((&mut arm,), (&mut touch,), clear {})?; // Wait holds until a condition is met{% endif %}
    for phase in [Phase::Out, Phase::Back] {
        mp.move_robots((&mut arm,), (), Ask(phase))?; // until the robot has finished the phase
    }
    Ok(())
}

/// Orders one phase, in every step the same.
struct Ask(Phase);

#[generator(mp)]
fn ask(c: &mut Ask) -> Always<(Arm,), Phase> {
    Always((c.0,))
}
