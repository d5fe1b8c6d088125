//! Where a robot is, and what it is told before it moves.

use core::time::Duration;
use std::net::IpAddr;

use crate::behaviour::SETS;
use crate::message::{Collision, PORT, Stiffness};

/// How long the robot may say nothing: after 20 answers that did not come it has stopped by itself.
const SILENCE: Duration = Duration::from_millis(20);

/// Where a robot is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FciSettings {
    /// The robot's address: nobody else's states are looked at.
    pub robot: IpAddr,
    /// The port at which it takes requests, 1337.
    pub port: u16,
    /// How long it may say nothing before its drives count as lost, 20 ms; it counts in the time of a stop. A real robot has
    /// stopped by itself by then. A simulator on a busy machine may only be late.
    pub silence: Duration,
    /// When the robot takes something for a collision; `None`, the default, leaves that as it is.
    pub collision: Option<Collision>,
    /// How hard it holds its joints, for each parameter set of its regulators. `None` in set 0, the default, leaves that as it
    /// is, and then there is no other set.
    pub stiffness: [Option<Stiffness>; SETS],
}

impl FciSettings {
    /// With the interface's port and timeout.
    #[must_use]
    pub const fn new(robot: IpAddr) -> FciSettings {
        FciSettings { robot, port: PORT, silence: SILENCE, collision: None, stiffness: [None; SETS] }
    }
}
