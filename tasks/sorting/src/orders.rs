//! What the coordinator tells the robots: loosely, a task that each carries out on its own.

use mrroc::prelude::*;

/// A task of the arm and its hand.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Payload)]
pub enum Task {
    /// Acquire the next part that comes.
    Pick,
    /// Arm: bring it to the tray for its length.
    Carry {
        /// The tray of parts shorter than [`LIMIT`](crate::places::LIMIT): its number in [`TRAYS`](crate::places::TRAYS).
        short: u32,
        /// That of the others.
        long: u32,
    },
    /// Hand: let it go.
    Release,
    /// Arm: back to where it waits.
    Return,
}
