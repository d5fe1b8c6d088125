//! A hand, how it is reached, and how it grasps.

use core::time::Duration;
use std::net::SocketAddr;

/// A hand at an address.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HandSettings {
    /// Where its robot listens for it.
    pub address: SocketAddr,
    /// How fast the opening changes [m/s], > 0: 0.1 by default, which is 0.05 for each finger.
    pub speed: f64,
    /// How hard it presses on what it grasps \[N\], > 0: 40 by default. A hand may hold 70 N for long.
    pub force: f64,
    /// How long a motion may take, 10 s by default.
    pub timeout: Duration,
    /// How long the hand may say nothing, 1 s by default: then the connection counts as lost. The cell does not count this in the
    /// time of its stops.
    pub silence: Duration,
    /// How often the EDP looks at what the hand has said, 2 ms by default; it divides the step, or the step divides it.
    pub period: Duration,
}

impl HandSettings {
    /// With the defaults.
    #[must_use]
    pub const fn new(address: SocketAddr) -> HandSettings {
        HandSettings {
            address,
            speed: 0.1,
            force: 40.0,
            timeout: Duration::from_secs(10),
            silence: Duration::from_secs(1),
            period: Duration::from_millis(2),
        }
    }

    pub(super) fn hardware(&self) -> String {
        format!("Franka Hand {}", self.address)
    }
}
