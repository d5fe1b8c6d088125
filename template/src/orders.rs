//! What the coordinator tells the robots.

use mrroc::payload::Payload;

/// FILL IN: the phases of the task. With an `enum` each robot decides how to do them; a `struct` of numbers leads it in
/// every step.
#[derive(Clone, Copy, Debug, PartialEq, Payload)]
pub enum Phase {
    Out,
    Back,
}
