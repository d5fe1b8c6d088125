//! A gripper, how it is reached, and what its numbers mean.

use core::time::Duration;
use std::net::SocketAddr;

use mrroc::fault::Excess;
use mrroc::robot::DriveFault;
use mrroc_robots::TwoFingers;

/// How the gripper's numbers belong to openings: linear between two of them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Openings {
    /// The widest opening \[m\], and the gripper's number there.
    pub widest: (f64, u8),
    /// The narrowest one \[m\], less than the widest, and its number.
    pub narrowest: (f64, u8),
}

impl Openings {
    /// A 2F-85 with the fingertips that it comes with: 85 mm at 3, closed at 230, as its drivers for ROS 2 have it. It is not
    /// quite linear between.
    pub const OF_85: Openings = Openings { widest: (TwoFingers::STROKE, 3), narrowest: (0.0, 230) };

    /// Opening that belongs to one number \[m\]: negative.
    pub(crate) fn slope(&self) -> f64 {
        let (widest, narrowest) = (self.widest, self.narrowest);
        (widest.0 - narrowest.0) / (f64::from(widest.1) - f64::from(narrowest.1))
    }

    /// The opening at a number \[m\].
    #[must_use]
    pub fn opening(&self, number: u8) -> f64 {
        self.widest.0 + (f64::from(number) - f64::from(self.widest.1)) * self.slope()
    }

    /// The number nearest to an opening \[m\].
    ///
    /// # Errors
    /// It is beyond all numbers.
    pub fn number(&self, opening: f64) -> Result<u8, DriveFault> {
        let number = (f64::from(self.widest.1) + (opening - self.widest.0) / self.slope()).round();
        if (0.0..=255.0).contains(&number) {
            return Ok(number as u8);
        }
        let limit = if number < 0.0 { self.opening(0) } else { self.opening(255) };
        Err(DriveFault::exceeded(0, "demanded opening", Excess::new(opening, limit, "m")))
    }

    /// The largest distance of the fingers from a demand \[m\]: all that they can move. What they hold stops them anywhere.
    #[must_use]
    pub fn range(&self) -> f64 {
        255.0 * self.slope().abs()
    }
}

/// A gripper at an address.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RobotiqSettings {
    /// Where it, or the gateway before it, listens.
    pub address: SocketAddr,
    /// Its unit there: 9 by default.
    pub unit: u8,
    /// Its openings.
    pub openings: Openings,
    /// The current that its motor may take, which is the force: 0 to 255, 64 by default. Of a 2F-85 that is 20 to 235 N.
    pub force: u8,
    /// How long the gripper's answer to a question may take, 500 ms by default: then the connection counts as lost, and where
    /// a gateway is only busy, after twice as long. The cell does not count this in the time of its stops.
    pub timeout: Duration,
    /// How often the EDP looks at what was exchanged, 2 ms by default; it divides the step, or the step divides it.
    pub period: Duration,
}

impl RobotiqSettings {
    /// A 2F-85, with the defaults.
    #[must_use]
    pub const fn new(address: SocketAddr) -> RobotiqSettings {
        RobotiqSettings {
            address,
            unit: 9,
            openings: Openings::OF_85,
            force: 64,
            timeout: Duration::from_millis(500),
            period: Duration::from_millis(2),
        }
    }
}
