//! An exchange with a device that goes on beside the servo periods, and what a reset does with it.
//!
//! In: a session, and what its protocol and the drives hand to each other, in atomics, so that neither waits for the other. Out: that, as
//! long as the newest reading is not too old, or why there is no more of it.

use core::time::Duration;
use std::sync::Arc;

use crate::session::{Network, Session};
use crate::times::Times;

/// An exchange that goes on, and ends when this is dropped.
///
/// ```
/// use core::time::Duration;
/// use std::sync::Arc;
/// use mrroc_driver_kit::{Exchange, Network, NotConnected, Number, Peer, Protocol, Received, Session, Times};
///
/// #[derive(Default)]
/// struct Level(Times, Number);
/// impl AsRef<Times> for Level {
///     fn as_ref(&self) -> &Times {
///         &self.0
///     }
/// }
///
/// /// Each byte that comes is the level of a tank.
/// struct Tank(Arc<Level>);
/// impl Protocol for Tank {
///     type Fault = &'static str;
///
///     fn poll(&mut self, now: Duration, received: Received, _: &mut Vec<u8>) -> Result<Duration, &'static str> {
///         if let Some(byte) = received.bytes.last() {
///             self.0.1.set(f64::from(*byte));
///             self.0.0.hear(now);
///         }
///         if received.is_closed { Err("the tank has hung up") } else { Ok(Duration::MAX) }
///     }
///
///     fn not_connected(&self, _: NotConnected) -> &'static str {
///         "nobody is there"
///     }
/// }
///
/// let device = std::net::TcpListener::bind("127.0.0.1:0")?;
/// let peer = Peer { address: device.local_addr()?, timeout: Duration::from_secs(1), sends_datagrams: false };
/// let begin = || {
///     let level = Arc::new(Level::default());
///     let session = Session::begin(&Network::SOCKETS, "tank", peer, Tank(Arc::clone(&level)), "closed");
///     let session = session.map_err(|_| "no thread")?;
///     Ok::<_, &str>(Exchange::new(session, level, Duration::from_secs(5), "silent"))
/// };
/// let (mut exchange, mut recovers) = (Some(begin()?), false);
/// drop(device.accept()?);
/// // It has ended: a reset begins it anew, and is over when something is heard.
/// while !recovers {
///     assert!(!Exchange::recall(&mut exchange, &mut recovers, begin)?);
/// }
/// let (mut socket, _) = device.accept()?;
/// std::io::Write::write_all(&mut socket, &[7])?;
/// while !Exchange::recall(&mut exchange, &mut recovers, begin)? {}
/// assert_eq!(exchange.map(|exchange| exchange.shared().1.get()), Some(7.0));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct Exchange<S, F> {
    session: Session<F>,
    shared: Arc<S>,
    /// How old the newest reading may be, and why there is no more of it where it is older.
    silence: Duration,
    silent: F,
}

impl<S: AsRef<Times>, F: Copy + Send + Sync + 'static> Exchange<S, F> {
    /// Of a session whose protocol shares this with the drives. Its newest reading may be as old as `silence`, or it ends with `silent`.
    pub const fn new(session: Session<F>, shared: Arc<S>, silence: Duration, silent: F) -> Self {
        Exchange { session, shared, silence, silent }
    }

    /// What the protocol and the drives hand to each other.
    pub fn shared(&self) -> &S {
        &self.shared
    }

    /// The same, with the newest reading in it; `None` before the first one.
    ///
    /// # Errors
    /// Why nothing more is heard.
    pub fn heard(&self) -> Result<Option<&S>, F> {
        self.session.goes_on()?;
        let times = self.shared().as_ref();
        if !times.has_heard() {
            return Ok(None);
        }
        // The protocol says so as well, unless its thread is given no time.
        if times.is_silent_for(self.session.now(), self.silence) {
            return Err(self.silent);
        }
        Ok(Some(self.shared()))
    }

    /// Waits for the first reading, before a cell runs.
    ///
    /// # Errors
    /// Why nothing is heard.
    pub fn wait(&self, network: &Network) -> Result<(), F> {
        while self.heard()?.is_none() {
            network.wait(Duration::from_millis(1));
        }
        Ok(())
    }

    /// Asks now for what goes on only while it is asked for, such as a homing.
    pub fn ask(&self) {
        self.shared().as_ref().ask(self.session.now());
    }

    /// Goes on with a reset, from one call to the next, until the exchange is one that has heard something: whether that is so. One that
    /// has ended is begun anew once; `recovers` says that the present one was begun by this reset, and is kept between calls. Nothing here
    /// waits.
    ///
    /// # Errors
    /// An exchange that this reset has begun has ended, or it cannot begin.
    pub fn recall(
        exchange: &mut Option<Self>,
        recovers: &mut bool,
        begin: impl FnOnce() -> Result<Self, F>,
    ) -> Result<bool, F> {
        match exchange.as_ref().map(Self::heard) {
            Some(Ok(Some(_))) => {
                *recovers = false;
                return Ok(true);
            }
            Some(Ok(None)) => return Ok(false),
            Some(Err(fault)) if *recovers => {
                *recovers = false;
                return Err(fault);
            }
            Some(Err(_)) | None => {}
        }
        // A thread that waits for an answer ends soon, and is not waited for here. The device goes on holding what it holds.
        if let Some(session) =
            exchange.as_ref().map(|exchange| &exchange.session).filter(|one| !one.is_over())
        {
            session.hang_up();
            return Ok(false);
        }
        *exchange = Some(begin()?);
        *recovers = true;
        Ok(false)
    }
}
