//! The coordinator: the task as a sequence of instructions.

use mrroc::prelude::*;

use crate::arm::Arm; // the kind of robots
use crate::orders::Phase; // what they are told{% if sensor == "touch" %}
use crate::touch::{Touch, clear}; // what is sensed{% endif %}

/// FILL IN: the phases in the order in which the task needs them.
pub fn coordinate(mp: &mut Mp) -> Result<(), Fault> {
    let mut left = mp.robot::<Arm>("left")?; // named as in cell.toml
    let mut right = mp.robot::<Arm>("right")?; // as well{% if sensor == "touch" %}
    let mut touch = mp.sensor::<Touch>("touch")?; // this too
    mp.wait_until((&mut left,), (&mut touch,), clear {})?; // Wait holds until a condition is met{% endif %}
    for phase in [Phase::Out, Phase::Back] {
        mp.move_robots((&mut left, &mut right), (), Ask(phase))?; // until both have finished the phase
    }
    Ok(())
}

/// Orders one phase, in every step the same.
struct Ask(Phase);

#[generator(mp)]
fn ask(c: &mut Ask) -> Always<(Arm, Arm), Phase> {
    Always((c.0, c.0))
}
