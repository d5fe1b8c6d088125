//! The Franka Hand: a gripper, and a robot of its own, of one joint that is the opening between its fingers.
//!
//! **Never run on a real hand.** It was run against the hands of franka-sim and franky-sim, and against one of this crate's tests
//! that Franka's own client drives as well (`tests/peers/drives`).
//!
//! The hand takes whole motions, not positions for its periods: move to an opening, or grasp, one at a time, and it answers when
//! the fingers stand. So a session of its own exchanges messages with it, and tells it a position when demands have stood there for 20 ms: the
//! fingers begin when a motion of the program is over, also where a stop or a suspension has ended it early. What is demanded
//! while they move ends that motion first. The servo periods of the EDP hand over the newest position and take the newest state;
//! they never wait.
//!
//! **Grasp.** Fingers that are told to close grasp, with the force of [`HandSettings`]: they close until something stops them, be
//! it narrower than the demand, and then they press. With parameter set 1 of [`Hand`] they move to the opening and press on
//! nothing, and a part in their way is a fault. What is grasped keeps its grip when something narrower is demanded, when the
//! connection ends, and at a reset: nothing is told to the hand before another position is demanded than the one where it is. The
//! first digital input is on while something is grasped.
//!
//! **Homing.** A hand that has not measured how far it opens takes no motion. It measures that by moving its fingers, which let fall
//! what they hold: so nothing does it by itself, and no reset. `homed = false` in `cell.toml` does, when the cell starts, if it was
//! not done since the robot was switched on.

mod drives;
#[cfg(test)]
mod fake;
mod faults;
mod message;
mod protocol;
mod settings;
mod shared;
#[cfg(test)]
mod tests;

use mrroc::cell::RobotSetup;
use mrroc_launch::cell_file::Kinds;
use mrroc_robots::{One, Simulated, TwoFingers};

pub use drives::{Hand, HandHoming};
pub use message::{Answer, Outcome, PORT, Request, STATE, State, VERSION};
pub use settings::HandSettings;

/// How far the fingers of the hand open \[m\].
pub const STROKE: f64 = 0.08;

/// The fingers: [`TwoFingers`] that open by [`STROKE`].
#[must_use]
pub fn fingers() -> TwoFingers {
    TwoFingers::new().with_stroke(STROKE)
}

/// Adds the kind `franka-hand`: [`fingers`] at the `address` of their robot, on port 1338 unless it says another one. Simulated drives,
/// from `start` on, stand in where nothing real may move. With `homed = false` a hand that has not measured how far it opens does so
/// when the cell starts, which **moves its fingers**.
#[must_use]
pub fn with_franka_hand(kinds: Kinds) -> Kinds {
    kinds.with("franka-hand", |entry| {
        let fingers = fingers().with_base(entry.base());
        let settings = HandSettings::new(entry.address_and_port(PORT)?);
        let stand_in = Simulated::new(fingers.clone(), &entry.start(&fingers)?);
        let setup = if entry.is_homed() {
            RobotSetup::new(entry.name(), fingers, Hand::new(settings))
        } else {
            RobotSetup::unhomed(entry.name(), fingers, HandHoming::new(settings))
        };
        // The fingers begin when the demands stand, and what they grasp keeps them off their demand: that is no fault.
        Ok(setup.stand_in(stand_in).following_error(One::new(STROKE)))
    })
}
