//! Robotiq two-finger grippers for mrroc, by Modbus TCP: at a gateway before the gripper, or a controller that has its
//! registers.
//!
//! **Never run on a real gripper.** It was run against servers of pymodbus with a model of the fingers
//! (`tests/peers/drives`).
//!
//! A thread of its own exchanges registers with the gripper, at most 200 times a second. The servo periods of the EDP hand
//! it the newest position and take its newest reading; they never wait for it. The messages are those of `mrroc-modbus`.
//!
//! **Activation.** After each loss of its power a gripper must be activated, and then its fingers open and close as far as
//! they can: they let fall what they hold, and pinch what is between them. So nothing does it by itself. A gripper that is
//! not activated keeps its cell from beginning, and a reset says so again, because an operator who resets a cell for
//! another robot's sake may not see what the fingers hold. `homed = false` in `cell.toml` activates it when the cell starts
//! and at no other time, if it is not active then: remove what it holds before.
//!
//! **Grasp.** What the fingers hold stops them short of their demand, which is no following error; how hard they press, the
//! force of [`RobotiqSettings`] and the parameter sets of [`Robotiq`] say. When the connection ends, by a fault, a kill of
//! its EDP or the end of the cell, nothing is written any more, and a gripper goes on with the position that it was told
//! last: it keeps its grip. After a reset demands begin there, so that it keeps it then, too.
//!
//! ```no_run
//! use mrroc_robotiq::with_robotiq;
//!
//! // kind = "robotiq-2f85" in cell.toml, with address and start.
//! let kinds = with_robotiq(mrroc_robots::simulated());
//! ```

mod drives;
mod protocol;
pub mod registers;
mod settings;
#[cfg(test)]
mod tests;

use mrroc::cell::RobotSetup;
use mrroc_launch::cell_file::Kinds;
use mrroc_robots::{One, Simulated, TwoFingers};

pub use mrroc_modbus::PORT;

pub use drives::{Activation, Robotiq};
pub use settings::{Openings, RobotiqSettings};

/// Adds the kind `robotiq-2f85`: [`TwoFingers`] at an `address`, on port 502 unless it says another one. Simulated drives,
/// from `start` on, stand in where nothing real may move. With `homed = false` a gripper that is not active is activated
/// when the cell starts, which **opens and closes its fingers**.
#[must_use]
pub fn with_robotiq(kinds: Kinds) -> Kinds {
    kinds.with("robotiq-2f85", |entry| {
        let gripper = TwoFingers::new().with_base(entry.base());
        let settings = RobotiqSettings::new(entry.address_and_port(PORT)?);
        let stand_in = Simulated::new(gripper.clone(), &entry.start(&gripper)?);
        let setup = if entry.is_homed() {
            RobotSetup::new(entry.name(), gripper, Robotiq::new(settings))
        } else {
            RobotSetup::unhomed(entry.name(), gripper, Activation::new(settings))
        };
        // What is grasped keeps the fingers off their demand: that is no fault.
        Ok(setup.stand_in(stand_in).following_error(grasping(&settings)))
    })
}

/// The following error for a set-up: as far as the fingers can go \[m\].
#[must_use]
pub fn grasping(settings: &RobotiqSettings) -> One {
    One::new(settings.openings.range())
}
