//! The drives of a hand, and its homing as the search of drives that do not know where they are.
//!
//! In: openings. Out: the newest state of the hand. Nothing here waits, but for opening and closing.

use core::time::Duration;
use std::net::SocketAddr;

use mrroc::robot::{
    ANALOG, Channels, DriveFault, Driver, Homing, Measured, Recovery, Regulators, Robot, Search, Signals,
    Values, WhenLost,
};
use mrroc_driver_kit::{Network, recall};
use mrroc_robots::One;

use super::exchange::{HandStatus, Link, Unhomed};
use super::faults::CLOSED;

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

    fn hardware(&self) -> String {
        format!("Franka Hand {}", self.address)
    }
}

/// The drives of any robot of one joint that is the opening between its fingers \[m\].
///
/// Of their parameter sets 0 grasps where it closes, with the force of the settings, and 1 moves to the opening and presses on nothing.
/// A set holds from the next motion on. Digital input 0 is on while something is grasped.
#[derive(Debug)]
pub struct Hand {
    settings: HandSettings,
    network: Network,
    presses: bool,
    link: Option<Link>,
    /// Whether the link is one that a reset has begun.
    recovers: bool,
}

impl Hand {
    /// Drives that connect to nothing before they are opened. A hand that is not homed is refused.
    #[must_use]
    pub const fn new(settings: HandSettings) -> Hand {
        Hand::over(Network::SOCKETS, settings)
    }

    /// The same over another network, such as one of tests.
    #[must_use]
    pub const fn over(network: Network, settings: HandSettings) -> Hand {
        Hand { settings, network, presses: true, link: None, recovers: false }
    }

    fn link(&self) -> Result<&Link, DriveFault> {
        self.link.as_ref().ok_or(CLOSED)
    }

    fn heard(&self) -> Result<HandStatus, DriveFault> {
        self.link()?.heard()?.ok_or(CLOSED)
    }
}

fn connect(network: &Network, settings: &HandSettings, presses: bool) -> Result<Link, DriveFault> {
    Link::begin(network, settings, presses, Unhomed::Refused)
}

fn measured(heard: &HandStatus) -> Measured<One> {
    Measured { position: One::new(heard.width), velocity: One::new(heard.speed) }
}

impl<R: Robot<Joints = One>> Driver<R> for Hand {
    fn period(&self) -> Duration {
        self.settings.period
    }

    fn hardware(&self) -> Option<String> {
        Some(self.settings.hardware())
    }

    fn open(&mut self) -> Result<(), DriveFault> {
        // A hand has one connection at a time.
        self.link = None;
        let link = connect(&self.network, &self.settings, self.presses)?;
        while link.heard()?.is_none() {
            self.network.wait(Duration::from_millis(1));
        }
        self.link = Some(link);
        Ok(())
    }

    fn close(&mut self) {
        // It goes on holding what it holds.
        self.link = None;
    }

    fn held(&self) -> Option<One> {
        self.link.as_ref().map(|link| One::new(link.demanded()))
    }

    fn measured(&self) -> Result<Measured<One>, DriveFault> {
        Ok(measured(&self.heard()?))
    }

    fn tick(&mut self, demanded: &One) -> Result<Measured<One>, DriveFault> {
        let heard = self.heard()?;
        self.link()?.go_to(demanded[0])?;
        Ok(measured(&heard))
    }

    fn channels(&self) -> Channels {
        Channels { digital_inputs: 1, when_lost: WhenLost::Hold, ..Channels::NONE }
    }

    fn signals(&self) -> Signals {
        let is_grasped = self.heard().is_ok_and(|heard| heard.is_grasped);
        Signals { inputs: Values::new(u32::from(is_grasped), [0.0; ANALOG]), ..Signals::OFF }
    }

    /// Connects again, if the exchange has ended.
    fn recover(&mut self) -> Result<Recovery, DriveFault> {
        let Self { settings, network, presses, link, recovers } = self;
        let is_over = recall(link, recovers, || connect(network, settings, *presses))?;
        Ok(if is_over { Recovery::Over } else { Recovery::GoesOn })
    }

    fn switch_on(&mut self) -> Result<(), DriveFault> {
        self.heard().map(drop)
    }

    fn has_regulator(&self, _joint: usize, set: u8) -> bool {
        set <= 1
    }

    fn choose_regulators(&mut self, sets: &Regulators) {
        self.presses = sets.set(0) == 0;
        if let Some(link) = &self.link {
            link.press(self.presses);
        }
    }
}

/// A hand that is homed when the cell starts, if it is not: **its fingers move**, and let go what they hold.
///
/// As any search for reference marks it is over before a program begins. While the cell is suspended the hand is told to stop, 100 ms
/// after the last call; then it begins anew.
#[derive(Debug)]
pub struct HandHoming {
    settings: HandSettings,
    network: Network,
    link: Option<Link>,
}

impl HandHoming {
    /// Nothing is connected before the search begins.
    #[must_use]
    pub const fn new(settings: HandSettings) -> HandHoming {
        HandHoming::over(Network::SOCKETS, settings)
    }

    /// The same over another network, such as one of tests.
    #[must_use]
    pub const fn over(network: Network, settings: HandSettings) -> HandHoming {
        HandHoming { settings, network, link: None }
    }
}

impl<R: Robot<Joints = One>> Homing<R> for HandHoming {
    type Drives = Hand;

    fn period(&self) -> Duration {
        self.settings.period
    }

    fn hardware(&self) -> Option<String> {
        Some(self.settings.hardware())
    }

    fn search(self) -> Result<Search<Self, Hand>, DriveFault> {
        let HandHoming { settings, network, link } = self;
        let link = link.map_or_else(|| Link::begin(&network, &settings, true, Unhomed::Homed), Ok)?;
        link.ask_for_homing();
        let found = link.heard()?.is_some();
        let link = Some(link);
        Ok(if found {
            Search::Found(Hand { settings, network, presses: true, link, recovers: false })
        } else {
            Search::Searching(HandHoming { settings, network, link })
        })
    }
}
