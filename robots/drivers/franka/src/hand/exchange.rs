//! The exchange with the hand, beside the servo periods.
//!
//! In: the opening that is demanded. Out: the hand's newest state, or why there is no more of it. What goes on in it is in `protocol.rs`.

use core::sync::atomic::{AtomicBool, Ordering};
use core::time::Duration;
use std::sync::Arc;

use mrroc::fault::Excess;
use mrroc::robot::DriveFault;
use mrroc_driver_kit::{Network, Number, Peer, Recalled, Session, Times};

use super::drives::HandSettings;
use super::faults::{CLOSED, SILENT};
use super::protocol::HandProtocol;

/// How long the hand may take to accept the connection, and to answer it.
pub(crate) const CONNECT: Duration = Duration::from_secs(1);

/// Whether the hand may be homed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unhomed {
    /// One that is not homed is refused.
    Refused,
    /// One that is not homed is homed, while that is [asked for](Link::ask_for_homing).
    Homed,
}

/// What the exchange and the drives hand to each other.
#[derive(Debug, Default)]
pub(crate) struct Shared {
    pub(crate) times: Times,
    /// The opening that is demanded \[m\].
    pub(crate) demanded: Number,
    /// Whether fingers that close grasp.
    pub(crate) presses: AtomicBool,
    /// The newest state: openings \[m\] and speed [m/s].
    pub(crate) width: Number,
    pub(crate) max_width: Number,
    pub(crate) speed: Number,
    pub(crate) is_grasped: AtomicBool,
}

/// What the hand says, as the drives see it.
#[derive(Clone, Copy, Debug)]
pub struct HandStatus {
    /// The opening \[m\], and its speed [m/s].
    pub width: f64,
    pub speed: f64,
    pub is_grasped: bool,
}

/// An exchange that goes on.
#[derive(Debug)]
pub struct Link {
    session: Session<DriveFault>,
    shared: Arc<Shared>,
    /// How old the newest state may be.
    silence: Duration,
}

impl Link {
    /// Begins to connect, and returns.
    ///
    /// # Errors
    /// A thread cannot be started.
    pub fn begin(
        network: &Network,
        settings: &HandSettings,
        presses: bool,
        unhomed: Unhomed,
    ) -> Result<Link, DriveFault> {
        let shared = Arc::new(Shared { presses: AtomicBool::new(presses), ..Shared::default() });
        let protocol = HandProtocol::new(Arc::clone(&shared), *settings, unhomed);
        let peer = Peer { address: settings.address, timeout: CONNECT, sends_datagrams: true };
        let session = Session::begin(network, "hand", peer, protocol, CLOSED);
        let session = session.map_err(|_| DriveFault::Other("this machine starts no more threads"))?;
        Ok(Link { session, shared, silence: settings.silence })
    }

    /// The newest that was heard; `None` before the fingers are known to stand.
    ///
    /// # Errors
    /// Why nothing more is heard.
    pub fn heard(&self) -> Result<Option<HandStatus>, DriveFault> {
        self.session.goes_on()?;
        if !self.shared.times.has_heard() {
            return Ok(None);
        }
        // The exchange says so as well, unless its thread is given no time.
        if self.shared.times.is_silent_for(self.session.now(), self.silence) {
            return Err(SILENT);
        }
        let Shared { width, speed, is_grasped, .. } = &*self.shared;
        let is_grasped = is_grasped.load(Ordering::Relaxed);
        Ok(Some(HandStatus { width: width.get(), speed: speed.get(), is_grasped }))
    }

    /// Where the fingers stood when they were heard first, or were told to go last \[m\].
    pub fn demanded(&self) -> f64 {
        self.shared.demanded.get()
    }

    /// Where they are to go \[m\].
    ///
    /// # Errors
    /// They do not open or close as far as that.
    pub fn go_to(&self, width: f64) -> Result<(), DriveFault> {
        let limit = if width < 0.0 { 0.0 } else { self.shared.max_width.get() };
        // Where they stand they may stay, by whatever a bit that is beyond.
        if width != self.demanded() && !(0.0..=limit).contains(&width) {
            return Err(DriveFault::exceeded(0, "demanded opening", Excess::new(width, limit, "m")));
        }
        self.shared.demanded.set(width);
        Ok(())
    }

    /// Whether fingers that close grasp, from the next motion on.
    pub fn press(&self, presses: bool) {
        self.shared.presses.store(presses, Ordering::Relaxed);
    }

    /// Lets a homing go on for a while.
    pub fn ask_for_homing(&self) {
        self.shared.times.ask(self.session.now());
    }
}

impl Recalled for Link {
    type Fault = DriveFault;

    fn has_heard(&self) -> Result<bool, DriveFault> {
        self.heard().map(|heard| heard.is_some())
    }

    /// Ends the exchange: the hand goes on holding what it holds.
    fn hang_up(&self) {
        self.session.hang_up();
    }

    fn is_over(&self) -> bool {
        self.session.is_over()
    }
}
