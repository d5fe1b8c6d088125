//! A controller with the Robot Sensor Interface, and how it is reached.

use core::time::Duration;
use std::net::{IpAddr, SocketAddr};

use crate::corrections::Corrections;

/// A controller, and where this machine listens for it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RsiSettings {
    /// This machine's address on the controller's network, and the port there: the `IP_NUMBER` and `PORT` of its
    /// configuration.
    pub listen: SocketAddr,
    /// The controller's address: messages of anybody else are not looked at.
    pub robot: IpAddr,
    /// The name that the controller's configuration gives this end, its `SENTYPE`; `ImFree` by default, as in KUKA's examples.
    pub sensor: String,
    /// The controller's period, 4 ms by default, or 12.
    pub period: Duration,
    /// What corrections count from: [`Corrections::Absolute`] by default.
    pub corrections: Corrections,
}

impl RsiSettings {
    /// With the defaults.
    #[must_use]
    pub fn new(listen: SocketAddr, robot: IpAddr) -> RsiSettings {
        RsiSettings {
            listen,
            robot,
            sensor: "ImFree".to_owned(),
            period: Duration::from_millis(4),
            corrections: Corrections::Absolute,
        }
    }
}
