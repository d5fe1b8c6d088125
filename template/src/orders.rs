//! What the coordinator tells the robots.

use mrroc::Payload;

/// FILL IN: the phases of the task; an `enum` leaves it to each robot how, a `struct` of numbers leads it step by step.
#[derive(Clone, Copy, Debug, PartialEq, Payload)]
pub enum Phase {
    Out,
    Back,
}
