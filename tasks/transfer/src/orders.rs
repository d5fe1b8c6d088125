//! What the coordinator tells the robots. Loose: a phase, which each carries out on its own. Tight: a
//! [`Displacement`](mrroc_generators::cooperation::Displacement) in every step.

use mrroc::Payload;
use mrroc_robots::{Gripper, Polycrank, Rnt};

/// The arms, as instructions name them together.
pub type Arms = (Rnt, Polycrank);
/// Their hands.
pub type Hands = [Gripper; 2];

/// A phase of the task.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Payload)]
pub enum Phase {
    /// Arms: go to the grasp.
    Approach,
    /// Hands: close.
    Close,
    /// Hands: open.
    Open,
    /// Arms: leave the grasp.
    Withdraw,
}
