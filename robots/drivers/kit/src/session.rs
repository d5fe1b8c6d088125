//! A session with a device: a protocol that goes on beside the servo periods, and what it has ended with.
//!
//! In: a protocol, and the network over which it runs. Out: whether it goes on, and the time since it began. What the protocol and the
//! drives hand to each other is their own, in atomics, so that neither waits for the other.

use core::time::Duration;
use std::io;
use std::sync::{Arc, OnceLock};

use crate::protocol::{NotConnected, Peer, Protocol, Received};
use crate::serial::Serial;
use crate::sockets::Thread;
use crate::task::{Running, Task};

/// Where sessions run. By default over the sockets of this machine, each in a thread of its own, by the monotonic clock; in tests over a
/// virtual connection.
#[derive(Clone, Debug)]
pub struct Network(Kind);

#[derive(Clone, Debug)]
enum Kind {
    Sockets,
    #[cfg(any(test, feature = "testing"))]
    Virtual(crate::testing::VirtualNetwork),
}

impl Network {
    /// The sockets and the clock of this machine.
    pub const SOCKETS: Network = Network(Kind::Sockets);

    /// Waits, before a cell runs: under a virtual clock, that time passes.
    #[expect(clippy::disallowed_methods, reason = "before the cell runs, a device is waited for")]
    pub fn wait(&self, time: Duration) {
        match &self.0 {
            Kind::Sockets => std::thread::sleep(time),
            #[cfg(any(test, feature = "testing"))]
            Kind::Virtual(network) => network.advance(time),
        }
    }

    fn run(&self, name: &str, peer: Peer, task: Box<dyn Task>) -> io::Result<Box<dyn Running>> {
        Ok(match &self.0 {
            Kind::Sockets => Box::new(Thread::start(name, peer, task)?),
            #[cfg(any(test, feature = "testing"))]
            Kind::Virtual(network) => Box::new(network.connect(peer, task)),
        })
    }
}

#[cfg(any(test, feature = "testing"))]
impl crate::testing::VirtualNetwork {
    /// It, for the drives.
    #[must_use]
    pub fn network(&self) -> Network {
        Network(Kind::Virtual(self.clone()))
    }
}

struct Run<P: Protocol> {
    protocol: P,
    outcome: Arc<OnceLock<P::Fault>>,
    closed: P::Fault,
}

impl<P: Protocol> Run<P> {
    fn end(&self, fault: P::Fault) {
        // The first is the cause.
        let _ = self.outcome.set(fault);
    }
}

impl<P: Protocol> Task for Run<P> {
    fn poll(&mut self, now: Duration, received: Received<'_>, send: &mut Vec<u8>) -> Option<Duration> {
        self.protocol.poll(now, received, send).map_err(|fault| self.end(fault)).ok()
    }

    fn fail(&mut self, why: NotConnected) {
        self.end(self.protocol.not_connected(why));
    }

    fn close(&mut self) {
        self.end(self.closed);
    }
}

/// A session that goes on by itself, and ends when this is dropped.
///
/// ```
/// use core::time::Duration;
/// use mrroc_driver_kit::{Network, NotConnected, Peer, Protocol, Received, Session};
///
/// /// Sends a greeting, and ends with the first byte of the answer.
/// struct Greeting(bool);
///
/// impl Protocol for Greeting {
///     type Fault = Option<u8>;
///
///     fn poll(&mut self, now: Duration, received: Received, send: &mut Vec<u8>) -> Result<Duration, Option<u8>> {
///         if !core::mem::replace(&mut self.0, true) {
///             send.extend(b"hello");
///         }
///         received.bytes.first().map_or(Ok(now + Duration::from_secs(1)), |byte| Err(Some(*byte)))
///     }
///
///     fn not_connected(&self, _: NotConnected) -> Option<u8> {
///         None
///     }
/// }
///
/// let device = std::net::TcpListener::bind("127.0.0.1:0")?;
/// let peer = Peer { address: device.local_addr()?, timeout: Duration::from_secs(1), sends_datagrams: false };
/// let session = Session::begin(&Network::SOCKETS, "greeting", peer, Greeting(false), None)?;
/// let (mut socket, _) = device.accept()?;
/// std::io::Write::write_all(&mut socket, b"!")?;
/// while session.goes_on().is_ok() {
///     std::thread::yield_now();
/// }
/// assert_eq!(session.goes_on(), Err(Some(b'!')));
/// # Ok::<(), std::io::Error>(())
/// ```
#[derive(Debug)]
pub struct Session<F> {
    outcome: Arc<OnceLock<F>>,
    closed: F,
    running: Box<dyn Running>,
}

impl<F: Copy + Send + Sync + 'static> Session<F> {
    /// Begins to connect, and returns. `name` is that of its thread; `closed` is why it has ended where it was told to.
    ///
    /// # Errors
    /// A thread cannot be started.
    pub fn begin<P: Protocol<Fault = F>>(
        network: &Network,
        name: &str,
        peer: Peer,
        protocol: P,
        closed: F,
    ) -> io::Result<Session<F>> {
        Session::of(protocol, closed, |task| network.run(name, peer, task))
    }

    /// The same over a serial line of this machine.
    pub(crate) fn begin_serial<P: Protocol<Fault = F>>(
        name: &str,
        port: Serial,
        protocol: P,
        closed: F,
    ) -> io::Result<Session<F>> {
        Session::of(protocol, closed, |task| Ok(Box::new(Thread::start_serial(name, port, task)?)))
    }

    fn of<P: Protocol<Fault = F>>(
        protocol: P,
        closed: F,
        start: impl FnOnce(Box<dyn Task>) -> io::Result<Box<dyn Running>>,
    ) -> io::Result<Session<F>> {
        let outcome = Arc::new(OnceLock::new());
        let run = Run { protocol, outcome: Arc::clone(&outcome), closed };
        Ok(Session { outcome, closed, running: start(Box::new(run))? })
    }

    /// Whether it goes on.
    ///
    /// # Errors
    /// Why it does not.
    pub fn goes_on(&self) -> Result<(), F> {
        let outcome = self.outcome.get().copied();
        // A thread that panicked has told nothing.
        outcome.or_else(|| self.is_over().then_some(self.closed)).map_or(Ok(()), Err)
    }
}

impl<F> Session<F> {
    /// The time since it began, by the clock that its protocol is given.
    #[must_use]
    pub fn now(&self) -> Duration {
        self.running.now()
    }

    /// Tells it to end, and returns.
    pub fn hang_up(&self) {
        self.running.hang_up();
    }

    /// Whether it has ended.
    #[must_use]
    pub fn is_over(&self) -> bool {
        self.running.is_over()
    }
}
