//! What the coordinator tells the robots.

use mrroc::payload::Payload;

/// How high the tools are above where they began [m].
#[derive(Clone, Copy, Debug, PartialEq, Payload)]
pub struct Lift {
    pub height: f64,
}
