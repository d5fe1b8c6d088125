//! A protocol as a state machine: it is given the time and what has come, and gives what is to be sent.
//!
//! A protocol reads no clock, waits for nothing and has no socket. So it runs the same over sockets in a thread of its own and under a
//! virtual clock, where a test knows to the nanosecond when something must happen.

use core::time::Duration;
use std::net::SocketAddr;

/// What has come from the device since the last poll.
#[derive(Clone, Copy, Debug, Default)]
pub struct Received<'a> {
    /// Bytes of the connection, in order, cut anywhere.
    pub bytes: &'a [u8],
    /// The newest datagram, where the [peer](Peer::sends_datagrams) sends some.
    pub datagram: Option<&'a [u8]>,
    /// The connection is closed: `bytes` are the last ones.
    pub is_closed: bool,
    /// The port at which the session takes datagrams; 0 where it takes none.
    pub port: u16,
}

/// The protocol of one device, from the moment when it is connected.
///
/// ```
/// use core::time::Duration;
/// use mrroc_driver_kit::{NotConnected, Protocol, Received};
///
/// /// Sends `?` every second, and expects an answer before the next one.
/// struct Ping { next: Duration, is_answered: bool }
///
/// impl Protocol for Ping {
///     type Fault = &'static str;
///
///     fn poll(&mut self, now: Duration, received: Received, send: &mut Vec<u8>) -> Result<Duration, &'static str> {
///         self.is_answered |= !received.bytes.is_empty();
///         if now >= self.next {
///             if !core::mem::take(&mut self.is_answered) {
///                 return Err("no answer came in time");
///             }
///             send.push(b'?');
///             self.next = now + Duration::from_secs(1);
///         }
///         Ok(self.next)
///     }
///
///     fn not_connected(&self, _: NotConnected) -> &'static str {
///         "nobody is there"
///     }
/// }
///
/// let (mut ping, mut sent) = (Ping { next: Duration::ZERO, is_answered: true }, Vec::new());
/// let nothing = Received::default();
/// assert_eq!(ping.poll(Duration::ZERO, nothing, &mut sent), Ok(Duration::from_secs(1)));
/// assert_eq!(sent, b"?");
/// assert_eq!(ping.poll(Duration::from_millis(999), nothing, &mut sent), Ok(Duration::from_secs(1)));
/// assert_eq!(ping.poll(Duration::from_secs(1), nothing, &mut sent), Err("no answer came in time"));
/// ```
pub trait Protocol: Send + 'static {
    /// Why the session ends.
    type Fault: Copy + Send + Sync + 'static;

    /// Takes in what has come by `now`, the time since the session began, and appends what is to be sent to `send`. Returns the time at
    /// which it must be polled again at the latest. It is polled first when the connection stands, and then whenever bytes come, the
    /// connection closes or that time is over; a datagram alone is no reason to poll it.
    ///
    /// # Errors
    /// The session ends with this fault. What is in `send` by then is sent first.
    fn poll(
        &mut self,
        now: Duration,
        received: Received<'_>,
        send: &mut Vec<u8>,
    ) -> Result<Duration, Self::Fault>;

    /// The fault of a session that could not begin.
    fn not_connected(&self, why: NotConnected) -> Self::Fault;
}

/// Why there is no connection.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NotConnected {
    /// Nothing has accepted it in time.
    Unreachable,
    /// This machine has no port for the datagrams of the device.
    NoPort,
}

/// The device that is to be connected.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Peer {
    /// Where it listens.
    pub address: SocketAddr,
    /// How long it may take to accept the connection.
    pub timeout: Duration,
    /// Whether it sends datagrams to this machine beside the connection.
    pub sends_datagrams: bool,
}
