//! What the coordinator tells the robot.

use mrroc::payload::Payload;

/// FILL IN: the tasks. With an `enum` the robot decides how to do them; they may carry data.
#[derive(Clone, Copy, Debug, PartialEq, Payload)]
pub enum Task {
    /// Get to this place [m, world], around whatever is in the way.
    Reach { x: f64, y: f64 },
}
