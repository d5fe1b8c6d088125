//! The coordinator: the task as a sequence of instructions.

use mrroc::prelude::*;
use mrroc_generators::generators::JointVelocity;
use mrroc_robots::{Conveyor, Irp6, One, TwoFingers};
use mrroc_sensors::virtual_sensors::{OnBelt, PartSensor};

use crate::orders::Task;

/// FILL IN: how fast the belt runs [m/s].
const SPEED: f64 = 0.1;
/// A part is taken from here on, along the belt [m]: the arm needs three seconds to be with it.
const FROM: f64 = -0.25;

/// FILL IN: the tasks in the order in which they are done; here, with the first part.
pub fn coordinate(mp: &mut Mp) -> Result<(), Fault> {
    let (mut arm, mut hand) = (mp.robot::<Irp6>("arm")?, mp.robot::<TwoFingers>("hand")?);
    let (mut belt, mut camera) = (mp.robot::<Conveyor>("belt")?, mp.sensor::<PartSensor>("camera")?);
    // The belt runs from now on, beside all that follows.
    mp.start_robot(&mut belt, JointVelocity::of(One::new(SPEED), One::new(0.04)))?;
    let OnBelt { along, across, angle, .. } =
        mp.wait_until((&mut arm,), (&mut camera,), Comes::default())?.part;
    for task in [Task::Take { along, across, angle }, Task::Bring, Task::Release] {
        mp.move_robots((&mut arm, &mut hand), (), Ask(task))?; // until both have finished it
    }
    mp.end_robot(&mut belt)
}

/// Holds when a part has come to where the arm can take it, and remembers which.
#[derive(Default)]
struct Comes {
    part: OnBelt,
}

#[condition(mp)]
fn comes(c: &mut Comes, v: &Reading<(PartSensor,)>) -> bool {
    let Some(seen) = v.0.reading() else { return false };
    // In the belt's own frame: there a part does not move, however long an image takes. The first that has come; the newest is told first.
    let come = |part: &&OnBelt| part.number > 0 && part.along + seen.travel > FROM;
    let Some(part) = seen.newest.iter().rev().find(come) else { return false };
    c.part = *part;
    true
}

/// Orders one task, in every step the same.
struct Ask(Task);

#[generator(mp)]
fn ask(c: &mut Ask) -> Always<(Irp6, TwoFingers), Task> {
    Always((c.0, c.0))
}
