//! The coordinator's program: it runs the belt, keeps the queue of parts, and has them taken to their bins one after another.

use core::cell::Cell;

use mrroc::prelude::*;
use mrroc_robots::{Conveyor, Irp6, TwoFingers};
use mrroc_sensors::virtual_sensors::PartSensor;

use super::orders::Task;
use super::queue::{Gap, Queue, Ready, Tell};
use crate::generators::Uneven;
use crate::mp::Failed;

/// Sorts what the belt brings, as long as the queue says that more comes; `eye` is the sensor that tells of parts. Counts in `failed` the
/// picks in which the hand closed on nothing: it is opened after every pick. A part that the arm cannot bring to its bin is put back into a
/// gap of the belt.
///
/// # Errors
/// The first fault of the cell; three picks in a row that failed; no gap came for a part that is to be put back.
pub fn coordinate(
    mp: &mut Mp,
    eye: &str,
    drive: Uneven,
    mut queue: Queue,
    failed: &Cell<Failed>,
) -> Result<Queue, Fault> {
    let mut arm = (mp.robot::<Irp6>("arm")?, mp.robot::<TwoFingers>("hand")?);
    let (mut belt, mut parts) = (mp.robot::<Conveyor>("belt")?, mp.sensor::<PartSensor>(eye)?);
    mp.start_robot(&mut belt, drive)?;
    queue = mp.move_robots((&mut arm.0, &mut arm.1), (&mut parts,), Tell(Task::Return, queue))?.1;
    loop {
        queue = mp.wait_until((&mut arm.0, &mut arm.1), (&mut parts,), Ready(queue))?.0;
        let Some(pick) = queue.pick() else {
            return mp.end_robot(&mut belt).map(|()| queue);
        };
        queue = mp.move_robots((&mut arm.0, &mut arm.1), (&mut parts,), Tell(pick, queue))?.1;
        queue.count_pick(failed)?;
        if queue.is_stranded() {
            queue = mp.wait_until((&mut arm.0, &mut arm.1), (&mut parts,), Gap(queue))?.0;
            queue = mp.move_robots((&mut arm.0, &mut arm.1), (&mut parts,), Tell(Task::PutBack, queue))?.1;
        }
        queue = mp.move_robots((&mut arm.0, &mut arm.1), (&mut parts,), Tell(Task::Release, queue))?.1;
    }
}
