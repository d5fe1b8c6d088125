//! The drives of a gripper, and its activation as the search of drives that do not know where they are.
//!
//! In: openings. Out: what the exchange of registers has brought last. Nothing here waits, but for opening and closing.

use core::time::Duration;

use mrroc::robot::{DriveFault, Driver, Homing, Measured, Recovery, Regulators, Robot, Search};
use mrroc_driver_kit::{Network, recall};
use mrroc_robots::One;

use crate::exchange::{Link, TimedStatus};
use crate::protocol::{CLOSED, Inactive};
use crate::settings::RobotiqSettings;

impl RobotiqSettings {
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
