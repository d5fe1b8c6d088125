//! The coordinator's program: it runs the belt, keeps the queue of parts, and has them taken to their bins one after another.

use mrroc::prelude::*;
use mrroc_robots::{Conveyor, Irp6, TwoFingers};
use mrroc_sensors::virtual_sensors::PartSensor;

use super::orders::Task;
use super::queue::{Queue, Ready, Tell};
use crate::generators::Uneven;

/// Sorts what the belt brings, as long as the queue says that more comes; `eye` is the sensor that tells of parts.
///
/// # Errors
/// The first fault of the cell.
pub fn coordinate(mp: &mut Mp, eye: &str, drive: Uneven, mut queue: Queue) -> Result<Queue, Fault> {
    let mut arm = (mp.robot::<Irp6>("arm")?, mp.robot::<TwoFingers>("hand")?);
    let (mut belt, mut parts) = (mp.robot::<Conveyor>("belt")?, mp.sensor::<PartSensor>(eye)?);
    mp.start_robot(&mut belt, drive)?;
    queue = mp.move_robots((&mut arm.0, &mut arm.1), (&mut parts,), Tell(Task::Return, queue))?.1;
    loop {
        queue = mp.wait_until((&mut arm.0, &mut arm.1), (&mut parts,), Ready(queue))?.0;
        let Some(pick) = queue.pick() else {
            return mp.end_robot(&mut belt).map(|()| queue);
        };
        for task in [pick, Task::Release] {
            queue = mp.move_robots((&mut arm.0, &mut arm.1), (&mut parts,), Tell(task, queue))?.1;
        }
    }
}
