//! The exchange of registers with a gripper, as fast as the device answers, whatever the EDP's periods.
//!
//! In: the newest position that is demanded. Out: the newest status, the speed of the fingers, and why it has ended. The exchange and
//! the drives hand this over in atomics, so that neither waits for the other. What goes on in it is in `protocol.rs`.

use core::sync::atomic::{AtomicU8, Ordering};
use core::time::Duration;
use std::sync::Arc;

use mrroc::robot::DriveFault;
use mrroc_driver_kit::{Network, Peer, Recalled, Session};
use mrroc_modbus::client::{CONNECT, lost};

use crate::protocol::{CLOSED, GripperProtocol, Inactive, Shared};
use crate::registers::Status;
use crate::settings::RobotiqSettings;

/// What the gripper says, as the drives see it.
#[derive(Clone, Copy, Debug)]
pub struct TimedStatus {
    pub status: Status,
    /// The speed of the fingers, in its numbers a second: positive while they close.
    pub speed: f64,
}

/// An exchange that goes on.
#[derive(Debug)]
pub struct Link {
    session: Session<DriveFault>,
    shared: Arc<Shared>,
    /// How old the newest reading may be: an exchange is two questions.
    timeout: Duration,
}

impl Link {
    /// Begins to connect, and returns.
    ///
    /// # Errors
    /// A thread cannot be started.
    pub fn begin(
        network: &Network,
        settings: &RobotiqSettings,
        inactive: Inactive,
    ) -> Result<Link, DriveFault> {
        let shared = Arc::new(Shared { force: AtomicU8::new(settings.force), ..Shared::default() });
        let peer = Peer { address: settings.address, timeout: CONNECT, sends_datagrams: false };
        let protocol = GripperProtocol::new(Arc::clone(&shared), settings, inactive);
        let session = Session::begin(network, "gripper", peer, protocol, CLOSED);
        let session = session.map_err(|_| DriveFault::Other("this machine starts no more threads"))?;
        Ok(Link { session, shared, timeout: settings.timeout * 2 })
    }

    /// The newest that was heard; `None` before the fingers are known to stand.
    ///
    /// # Errors
    /// Why nothing more is heard.
    pub fn heard(&self) -> Result<Option<TimedStatus>, DriveFault> {
        self.session.goes_on()?;
        if !self.shared.times.has_heard() {
            return Ok(None);
        }
        if self.shared.times.is_silent_for(self.session.now(), self.timeout) {
            return Err(lost("no reading came in time"));
        }
        let Shared { status, speed, .. } = &*self.shared;
        let status = Status::from_word(status.load(Ordering::Relaxed));
        Ok(status.map(|status| TimedStatus { status, speed: speed.get() }))
    }

    /// Where the fingers are held, or were told to go last.
    pub fn position(&self) -> u8 {
        self.shared.position.load(Ordering::Relaxed)
    }

    /// Where they are to go.
    pub fn go_to(&self, position: u8) {
        self.shared.position.store(position, Ordering::Relaxed);
    }

    /// With which force, from the next motion on.
    pub fn press_with(&self, force: u8) {
        self.shared.force.store(force, Ordering::Relaxed);
    }

    /// Lets an activation go on for a while.
    pub fn ask_for_activation(&self) {
        self.shared.times.ask(self.session.now());
    }
}

impl Recalled for Link {
    type Fault = DriveFault;

    fn has_heard(&self) -> Result<bool, DriveFault> {
        self.heard().map(|heard| heard.is_some())
    }

    /// Ends the exchange: the gripper goes on holding what it was told last.
    fn hang_up(&self) {
        self.session.hang_up();
    }

    fn is_over(&self) -> bool {
        self.session.is_over()
    }
}
