//! The drives of a hand, and its homing as the search of drives that do not know where they are.
//!
//! In: openings. Out: the newest state of the hand. Nothing here waits, but for opening and closing.

use core::time::Duration;
use std::sync::Arc;
use std::sync::atomic::Ordering;

use mrroc::robot::{
    ANALOG, Channels, DriveFault, Driver, Homing, Measured, Recovery, Regulators, Robot, Search, Signals,
    Values, WhenLost,
};
use mrroc_driver_kit::{Exchange, Network, Peer, Session};
use mrroc_robots::One;

use super::faults::{CLOSED, SILENT};
use super::protocol::{CONNECT, HandProtocol, Unhomed};
use super::settings::HandSettings;
use super::shared::Shared;

/// An exchange that goes on.
type Link = Exchange<Shared, DriveFault>;

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

    fn heard(&self) -> Result<&Shared, DriveFault> {
        self.link()?.heard()?.ok_or(CLOSED)
    }
}

/// Begins to connect, and returns.
fn connect(
    network: &Network,
    settings: &HandSettings,
    presses: bool,
    unhomed: Unhomed,
) -> Result<Link, DriveFault> {
    let shared = Arc::new(Shared::default());
    shared.presses.store(presses, Ordering::Relaxed);
    let protocol = HandProtocol::new(Arc::clone(&shared), *settings, unhomed);
    let peer = Peer { address: settings.address, timeout: CONNECT, sends_datagrams: true };
    let session = Session::begin(network, "hand", peer, protocol, CLOSED);
    let session = session.map_err(|_| DriveFault::Other("this machine starts no more threads"))?;
    Ok(Exchange::new(session, shared, settings.silence, SILENT))
}

fn measured(heard: &Shared) -> Measured<One> {
    Measured { position: One::new(heard.width.get()), velocity: One::new(heard.speed.get()) }
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
        let link = connect(&self.network, &self.settings, self.presses, Unhomed::Refused)?;
        link.wait(&self.network)?;
        self.link = Some(link);
        Ok(())
    }

    fn close(&mut self) {
        // It goes on holding what it holds.
        self.link = None;
    }

    fn held(&self) -> Option<One> {
        self.link.as_ref().map(|link| One::new(link.shared().demanded.get()))
    }

    fn measured(&self) -> Result<Measured<One>, DriveFault> {
        Ok(measured(self.heard()?))
    }

    fn tick(&mut self, demanded: &One) -> Result<Measured<One>, DriveFault> {
        let heard = self.heard()?;
        let measured = measured(heard);
        heard.go_to(demanded[0])?;
        Ok(measured)
    }

    fn channels(&self) -> Channels {
        Channels { digital_inputs: 1, when_lost: WhenLost::Hold, ..Channels::NONE }
    }

    fn signals(&self) -> Signals {
        let is_grasped = self.heard().is_ok_and(|heard| heard.is_grasped.load(Ordering::Relaxed));
        Signals { inputs: Values::new(u32::from(is_grasped), [0.0; ANALOG]), ..Signals::OFF }
    }

    /// Connects again, if the exchange has ended.
    fn recover(&mut self) -> Result<Recovery, DriveFault> {
        let Self { settings, network, presses, link, recovers } = self;
        let begin = || connect(network, settings, *presses, Unhomed::Refused);
        let is_over = Exchange::recall(link, recovers, begin)?;
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
            link.shared().presses.store(self.presses, Ordering::Relaxed);
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
        let link = link.map_or_else(|| connect(&network, &settings, true, Unhomed::Homed), Ok)?;
        link.ask();
        let found = link.heard()?.is_some();
        let link = Some(link);
        Ok(if found {
            Search::Found(Hand { settings, network, presses: true, link, recovers: false })
        } else {
            Search::Searching(HandHoming { settings, network, link })
        })
    }
}
