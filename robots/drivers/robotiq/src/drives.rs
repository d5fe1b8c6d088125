//! The drives of a gripper, and its activation as the search of drives that do not know where they are.
//!
//! In: openings. Out: what the exchange of registers has brought last. Nothing here waits, but for opening and closing.

use core::time::Duration;
use std::net::SocketAddr;

use mrroc::fault::Excess;
use mrroc::robot::{DriveFault, Driver, Homing, Measured, Recovery, Regulators, Robot, Search};
use mrroc_driver_kit::{Network, recall};
use mrroc_robots::{One, TwoFingers};

use crate::exchange::{Inactive, Link, TimedStatus};
use crate::protocol::CLOSED;

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
    fn slope(&self) -> f64 {
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

    fn hardware(&self) -> String {
        format!("Robotiq gripper {} unit {}", self.address, self.unit)
    }

    fn measured(&self, heard: &TimedStatus) -> Measured<One> {
        let position = One::new(self.openings.opening(heard.status.position()));
        Measured { position, velocity: One::new(heard.speed * self.openings.slope()) }
    }
}

/// The drives of any robot of one joint that is the opening between its fingers \[m\].
///
/// Their parameter sets are forces: 0 that of the settings, 1 the least, 2 the largest, from the next motion on.
#[derive(Debug)]
pub struct Robotiq {
    settings: RobotiqSettings,
    network: Network,
    link: Option<Link>,
    /// Whether the link is one that a reset has begun.
    recovers: bool,
}

impl Robotiq {
    /// Drives that connect to nothing before they are opened. A gripper that is not activated is refused.
    #[must_use]
    pub const fn new(settings: RobotiqSettings) -> Robotiq {
        Robotiq::over(Network::SOCKETS, settings)
    }

    /// The same over another network, such as one of tests.
    #[must_use]
    pub const fn over(network: Network, settings: RobotiqSettings) -> Robotiq {
        Robotiq { settings, network, link: None, recovers: false }
    }

    fn link(&self) -> Result<&Link, DriveFault> {
        self.link.as_ref().ok_or(CLOSED)
    }

    fn heard(&self) -> Result<TimedStatus, DriveFault> {
        self.link()?.heard()?.ok_or(CLOSED)
    }
}

impl<R: Robot<Joints = One>> Driver<R> for Robotiq {
    fn period(&self) -> Duration {
        self.settings.period
    }

    fn hardware(&self) -> Option<String> {
        Some(self.settings.hardware())
    }

    fn open(&mut self) -> Result<(), DriveFault> {
        // A gateway may have room for one connection.
        self.link = None;
        let link = Link::begin(&self.network, &self.settings, Inactive::Refused)?;
        while link.heard()?.is_none() {
            self.network.wait(Duration::from_millis(1));
        }
        self.link = Some(link);
        Ok(())
    }

    fn close(&mut self) {
        // It goes on holding what it was told last.
        self.link = None;
    }

    fn held(&self) -> Option<One> {
        self.link.as_ref().map(|link| One::new(self.settings.openings.opening(link.position())))
    }

    fn measured(&self) -> Result<Measured<One>, DriveFault> {
        Ok(self.settings.measured(&self.heard()?))
    }

    fn tick(&mut self, demanded: &One) -> Result<Measured<One>, DriveFault> {
        let heard = self.heard()?;
        self.link()?.go_to(self.settings.openings.number(demanded[0])?);
        Ok(self.settings.measured(&heard))
    }

    fn motor_currents(&self) -> Option<One> {
        self.heard().ok().map(|heard| One::new(heard.status.current()))
    }

    /// Connects again, if the exchange has ended.
    fn recover(&mut self) -> Result<Recovery, DriveFault> {
        let Self { settings, network, link, recovers } = self;
        let is_over = recall(link, recovers, || Link::begin(network, settings, Inactive::Refused))?;
        Ok(if is_over { Recovery::Over } else { Recovery::GoesOn })
    }

    fn switch_on(&mut self) -> Result<(), DriveFault> {
        self.heard().map(drop)
    }

    fn has_regulator(&self, _joint: usize, set: u8) -> bool {
        set <= 2
    }

    fn choose_regulators(&mut self, sets: &Regulators) {
        let force = match sets.set(0) {
            0 => self.settings.force,
            1 => 0,
            _ => 255,
        };
        if let Some(link) = &self.link {
            link.press_with(force);
        }
    }
}

/// A gripper that is activated if it is not active when the cell starts: **its fingers open and close as far as they can**,
/// and let go what they hold.
///
/// As any search for reference marks it is over before a program begins, and stops while the cell is suspended: 100 ms
/// after the last call, and the answer to one message, the fingers are told to stop; then it begins anew.
#[derive(Debug)]
pub struct Activation {
    settings: RobotiqSettings,
    network: Network,
    link: Option<Link>,
}

impl Activation {
    /// Nothing is connected before the search begins.
    #[must_use]
    pub const fn new(settings: RobotiqSettings) -> Activation {
        Activation::over(Network::SOCKETS, settings)
    }

    /// The same over another network, such as one of tests.
    #[must_use]
    pub const fn over(network: Network, settings: RobotiqSettings) -> Activation {
        Activation { settings, network, link: None }
    }
}

impl<R: Robot<Joints = One>> Homing<R> for Activation {
    type Drives = Robotiq;

    fn period(&self) -> Duration {
        self.settings.period
    }

    fn hardware(&self) -> Option<String> {
        Some(self.settings.hardware())
    }

    fn search(self) -> Result<Search<Self, Robotiq>, DriveFault> {
        let Activation { settings, network, link } = self;
        let link = link.map_or_else(|| Link::begin(&network, &settings, Inactive::Activated), Ok)?;
        link.ask_for_activation();
        let found = link.heard()?.is_some();
        let link = Some(link);
        Ok(if found {
            Search::Found(Robotiq { settings, network, link, recovers: false })
        } else {
            Search::Searching(Activation { settings, network, link })
        })
    }
}
