//! The drives of a gripper, and its activation as the search of drives that do not know where they are.
//!
//! In: openings. Out: what the exchange of registers has brought last. Nothing here waits, but for opening and closing.

use core::sync::atomic::Ordering;
use core::time::Duration;
use std::sync::Arc;

use mrroc::robot::{DriveFault, Driver, Homing, Measured, Recovery, Regulators, Robot, Search};
use mrroc_driver_kit::{Exchange, Network, Peer, Session};
use mrroc_modbus::client::{CONNECT, lost};
use mrroc_robots::One;

use crate::protocol::{CLOSED, GripperProtocol, Inactive, Shared};
use crate::registers::Status;
use crate::settings::RobotiqSettings;

/// An exchange that goes on.
type Link = Exchange<Shared, DriveFault>;

impl RobotiqSettings {
    fn hardware(&self) -> String {
        format!("Robotiq gripper {} unit {}", self.address, self.unit)
    }

    fn measured(&self, (status, speed): (Status, f64)) -> Measured<One> {
        let position = One::new(self.openings.opening(status.position()));
        Measured { position, velocity: One::new(speed * self.openings.slope()) }
    }
}

/// Begins to connect, and returns.
fn connect(network: &Network, settings: &RobotiqSettings, inactive: Inactive) -> Result<Link, DriveFault> {
    let shared = Arc::new(Shared::default());
    shared.force.store(settings.force, Ordering::Relaxed);
    let peer = Peer { address: settings.address, timeout: CONNECT, sends_datagrams: false };
    let protocol = GripperProtocol::new(Arc::clone(&shared), settings, inactive);
    let session = Session::begin(network, "gripper", peer, protocol, CLOSED);
    let session = session.map_err(|_| DriveFault::Other("this machine starts no more threads"))?;
    // An exchange is two questions.
    Ok(Exchange::new(session, shared, settings.timeout * 2, lost("no reading came in time")))
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

    /// The newest status, and the speed of the fingers.
    fn heard(&self) -> Result<(Status, f64), DriveFault> {
        let heard = self.link()?.heard()?;
        heard.and_then(|heard| Some((heard.status()?, heard.speed.get()))).ok_or(CLOSED)
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
        let link = connect(&self.network, &self.settings, Inactive::Refused)?;
        link.wait(&self.network)?;
        self.link = Some(link);
        Ok(())
    }

    fn close(&mut self) {
        // It goes on holding what it was told last.
        self.link = None;
    }

    fn held(&self) -> Option<One> {
        let position = self.link.as_ref()?.shared().position.load(Ordering::Relaxed);
        Some(One::new(self.settings.openings.opening(position)))
    }

    fn measured(&self) -> Result<Measured<One>, DriveFault> {
        Ok(self.settings.measured(self.heard()?))
    }

    fn tick(&mut self, demanded: &One) -> Result<Measured<One>, DriveFault> {
        let heard = self.heard()?;
        let position = self.settings.openings.number(demanded[0])?;
        self.link()?.shared().position.store(position, Ordering::Relaxed);
        Ok(self.settings.measured(heard))
    }

    fn motor_currents(&self) -> Option<One> {
        self.heard().ok().map(|(status, _)| One::new(status.current()))
    }

    /// Connects again, if the exchange has ended.
    fn recover(&mut self) -> Result<Recovery, DriveFault> {
        let Self { settings, network, link, recovers } = self;
        let is_over = Exchange::recall(link, recovers, || connect(network, settings, Inactive::Refused))?;
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
            link.shared().force.store(force, Ordering::Relaxed);
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
        let link = link.map_or_else(|| connect(&network, &settings, Inactive::Activated), Ok)?;
        link.ask();
        let found = link.heard()?.is_some();
        let link = Some(link);
        Ok(if found {
            Search::Found(Robotiq { settings, network, link, recovers: false })
        } else {
            Search::Searching(Activation { settings, network, link })
        })
    }
}
