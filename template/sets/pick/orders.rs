//! What the coordinator tells arm and hand.

use mrroc::prelude::*;

/// FILL IN: the tasks. With an `enum` each robot decides how to do them.
#[derive(Clone, Copy, Debug, PartialEq, Payload)]
pub enum Task {
    /// Take a part from the running belt. It lies so far along the belt where that had run 0, and across it [m], at an angle [rad].
    Take { along: f64, across: f64, angle: f64 },
    /// Bring it over the tray.
    Bring,
    /// Let it go.
    Release,
}
