//! How the drives reach their controller: datagrams, and the time.
//!
//! In: what the drives answer. Out: the controller's messages, and when each of them came in. [`Sockets`] are the real ones, with the
//! clock of this machine. A test hands in a model of a controller with a clock of its own, so that it runs in no time and is the same each time.

#![expect(clippy::disallowed_methods, reason = "the one place where the drives meet sockets and a clock")]

use core::time::Duration;
use std::io::{self, ErrorKind};
use std::net::{IpAddr, SocketAddr};
use std::time::Instant;

use mrroc_driver_kit::{Arrived, Counted, Datagram, Guest};

/// How often it is looked for a message while nothing else is to be done.
const LOOK: Duration = Duration::from_micros(200);

/// A network with one controller in it, and a clock.
pub trait Network {
    /// The time since some beginning, which is always the same one. It never goes back.
    fn now(&self) -> Duration;

    /// Listens for the controller's messages: for no others, and for none that came before.
    ///
    /// # Errors
    /// This machine has no such address, or its port is taken.
    fn listen(&mut self) -> io::Result<()>;

    /// Lets the port go.
    fn close(&mut self);

    /// The last message that has not been read. Older ones are thrown away. It returns at once.
    fn newest(&mut self) -> Option<Arrived<'_>>;

    /// Sends an answer. It returns at once.
    ///
    /// # Errors
    /// The network takes nothing, or nobody listens.
    fn send(&mut self, to: SocketAddr, bytes: &[u8]) -> io::Result<()>;

    /// Lets a little time pass: called only while the drives are opened.
    fn wait(&mut self);
}

/// A socket of this machine, and its clock.
#[derive(Debug)]
pub struct Sockets {
    listen: SocketAddr,
    robot: IpAddr,
    began: Instant,
    guest: Option<Guest>,
    last: Option<Datagram>,
}

impl Sockets {
    /// For messages of the controller at `robot` to the address and port `listen` of this machine. Nothing is opened yet.
    #[must_use]
    pub fn new(listen: SocketAddr, robot: IpAddr) -> Sockets {
        Sockets { listen, robot, began: Instant::now(), guest: None, last: None }
    }

    /// What was not taken of what came to this port; `None` while it is closed.
    #[must_use]
    pub fn counted(&self) -> Option<Counted> {
        self.guest.as_ref().map(Guest::counted)
    }
}

impl Network for Sockets {
    fn now(&self) -> Duration {
        self.began.elapsed()
    }

    fn listen(&mut self) -> io::Result<()> {
        // The port is let go before.
        self.close();
        self.guest = Some(Guest::expect(self.listen, self.robot)?);
        Ok(())
    }

    fn close(&mut self) {
        (self.guest, self.last) = (None, None);
    }

    fn newest(&mut self) -> Option<Arrived<'_>> {
        self.last = Some(self.guest.as_mut()?.newest()?);
        self.last.as_ref().map(|datagram| datagram.by_clock(self.began))
    }

    fn send(&mut self, to: SocketAddr, bytes: &[u8]) -> io::Result<()> {
        self.guest.as_ref().ok_or(ErrorKind::NotConnected)?.send(to, bytes)
    }

    fn wait(&mut self) {
        std::thread::sleep(LOOK);
    }
}
