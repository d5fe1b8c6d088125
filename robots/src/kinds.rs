//! The kinds of robots that a `cell.toml` may name, simulated.

use mrroc::{Kinds, RobotSetup};

use crate::irp6::Irp6;
use crate::simulated::SimulatedIrp6;

/// The robots of this crate, each simulated from the joint positions that the cell file gives as its `start`.
///
/// | kind | robot |
/// |---|---|
/// | `irp6` | [`Irp6`] with its nominal geometry, [`SimulatedIrp6`] |
///
/// [`Kinds::with`] puts the drives of a real robot in the place of a simulated one.
#[must_use]
pub fn simulated() -> Kinds {
    Kinds::new().with("irp6", |entry| {
        let robot = Irp6::nominal().with_base(entry.base());
        let drives = SimulatedIrp6::new(robot.clone(), &entry.start(&robot)?);
        Ok(RobotSetup::new(entry.name(), robot, drives))
    })
}
