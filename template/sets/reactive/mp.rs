//! The coordinator: the task as a sequence of instructions.

use mrroc::prelude::*;

use crate::arm::Arm;
use crate::orders::Task;

/// FILL IN: where the robot is to go, one place after the other [m, world].
pub const PLACES: [[f64; 2]; 2] = [[0.87, 0.24], [0.88, 0.0]];

/// FILL IN: the tasks in the order in which they are done. What needs memory of the whole task is decided here, between two motions.
pub fn coordinate(mp: &mut Mp) -> Result<(), Fault> {
    let mut arm = mp.robot::<Arm>("arm")?; // named as in cell.toml
    for [x, y] in PLACES {
        mp.move_robots((&mut arm,), (), Ask(Task::Reach { x, y }))?; // until the robot is there
    }
    Ok(())
}

/// Orders one task, in every step the same.
struct Ask(Task);

#[generator(mp)]
fn ask(c: &mut Ask) -> Always<(Arm,), Task> {
    Always((c.0,))
}
