//! Arm and hand: what each does in each task that the coordinator orders.

use mrroc::prelude::*;
use mrroc_generators::combinators::Sequence;
use mrroc_generators::generators::{JointMove, Sleep, StraightLine};
use mrroc_generators::line::ToolLimits;
use mrroc_generators::profile::ProfileLimits;
use mrroc_robots::{Irp6, One, TwoFingers};
use mrroc_sensors::virtual_sensors::Encoder;

use crate::belt::TRAY;
use crate::generators::{CLOSE, DOWN, Take};
use crate::orders::Task;

/// The arm; the belt's frame F is at `frame` in the world.
pub fn arm(ecp: &mut Ecp<Irp6>, frame: Pose) -> Result<(), Fault> {
    let mut encoder = ecp.sensor::<Encoder>("encoder")?;
    let limits = ProfileLimits { velocity: 0.3, acceleration: 0.8 };
    let limits = ToolLimits { translation: limits, rotation: limits };
    ecp.serve_all(|ecp, task| match task {
        Task::Take { along, across, angle } => {
            ecp.move_robot((&mut encoder,), Take::at(frame, along, across, angle)).map(drop)
        }
        Task::Bring => {
            let over = Pose::translation(TRAY[0], TRAY[1], 0.1) * Pose::rotation(DOWN);
            ecp.move_robot((), StraightLine::to(over, limits)).map(drop)
        }
        Task::Release => Ok(()),
    })
}

/// The hand: closes when the arm is beside the part, and opens over the tray.
pub fn hand(ecp: &mut Ecp<TwoFingers>) -> Result<(), Fault> {
    // To an opening [m]; one that is less than the part presses on it.
    let to = |opening| JointMove::to(One::new(opening), One::new(0.09), One::new(0.35));
    ecp.serve_all(|ecp, task| match task {
        Task::Take { .. } => ecp.move_robot((), Sequence::of(Sleep::lasting(CLOSE), to(0.04))).map(drop),
        Task::Bring => Ok(()),
        Task::Release => ecp.move_robot((), to(0.08)).map(drop),
    })
}
