//! How the drives reach their robot: a connection for requests, datagrams with states, and the time.
//!
//! In: requests, and answers to states. Out: the robot's answers, its states, and when each of these came in. [`Sockets`] are the real
//! ones, with the clock of this machine. A test hands in a model of a robot with a clock of its own, so that it runs in no time and is the
//! same each time.

#![expect(clippy::disallowed_methods, reason = "the one place where the drives meet sockets and a clock")]

use core::time::Duration;
use std::io::{self, ErrorKind, Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::time::Instant;

use mrroc::robot::DriveFault;
use mrroc_driver_kit::{Arrived, Datagram, Guest};

use crate::stops::{ABSENT, CUT_OFF};

/// How often it is looked for what the robot says while nothing else is to be done.
const LOOK: Duration = Duration::from_micros(100);

/// A network with one robot in it, and a clock.
pub trait Network {
    /// The time since some beginning, which is always the same one. It never goes back.
    fn now(&self) -> Duration;

    /// Connects to the robot, within `timeout`, and says the port at which its states are waited for. A connection from before is closed.
    ///
    /// # Errors
    /// The robot is not there; this machine has no port.
    fn connect(&mut self, timeout: Duration) -> Result<u16, DriveFault>;

    /// Closes the connection, and lets the port go.
    fn close(&mut self);

    /// Sends a request. It returns at once.
    ///
    /// # Errors
    /// The connection has ended, or takes nothing.
    fn ask(&mut self, request: &[u8]) -> io::Result<()>;

    /// Reads what has come of answers to requests, as far as there is room for it: how many bytes. It returns at once, with 0 where nothing
    /// has come.
    ///
    /// # Errors
    /// The connection has ended.
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize>;

    /// The last state that has not been read. Older ones are thrown away. It returns at once.
    fn newest(&mut self) -> Option<Arrived<'_>>;

    /// Sends an answer to a state. It returns at once.
    ///
    /// # Errors
    /// The network takes nothing.
    fn send(&mut self, to: SocketAddr, bytes: &[u8]) -> io::Result<()>;

    /// Lets a little time pass: called only while the drives are opened or closed.
    fn wait(&mut self);
}

/// Sockets of this machine, and its clock.
#[derive(Debug)]
pub struct Sockets {
    robot: SocketAddr,
    began: Instant,
    connection: Option<(TcpStream, Guest)>,
    last: Option<Datagram>,
}

impl Sockets {
    /// For a robot that takes requests at this address. Nothing is connected yet.
    #[must_use]
    pub fn new(robot: SocketAddr) -> Sockets {
        Sockets { robot, began: Instant::now(), connection: None, last: None }
    }
}

impl Network for Sockets {
    fn now(&self) -> Duration {
        self.began.elapsed()
    }

    fn connect(&mut self, timeout: Duration) -> Result<u16, DriveFault> {
        self.close();
        let call = || -> io::Result<TcpStream> {
            let stream = TcpStream::connect_timeout(&self.robot, timeout)?;
            stream.set_nodelay(true)?;
            stream.set_nonblocking(true)?;
            Ok(stream)
        };
        let stream = call().map_err(|_| ABSENT)?;
        // This machine's address in the connection to the robot.
        let own = stream.local_addr().map_err(|_| CUT_OFF)?.ip();
        let guest = Guest::expect(SocketAddr::new(own, 0), self.robot.ip())
            .map_err(|_| DriveFault::Other("this machine has no port for the robot's states"))?;
        let port = guest.address().port();
        self.connection = Some((stream, guest));
        Ok(port)
    }

    fn close(&mut self) {
        (self.connection, self.last) = (None, None);
    }

    fn ask(&mut self, request: &[u8]) -> io::Result<()> {
        let (stream, _) = self.connection.as_mut().ok_or(ErrorKind::NotConnected)?;
        // A request is far shorter than what a connection takes at once.
        stream.write_all(request)
    }

    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        let (stream, _) = self.connection.as_mut().ok_or(ErrorKind::NotConnected)?;
        match stream.read(into) {
            Ok(0) if !into.is_empty() => Err(ErrorKind::UnexpectedEof.into()),
            Err(why) if matches!(why.kind(), ErrorKind::WouldBlock | ErrorKind::Interrupted) => Ok(0),
            read => read,
        }
    }

    fn newest(&mut self) -> Option<Arrived<'_>> {
        self.last = Some(self.connection.as_mut()?.1.newest()?);
        self.last.as_ref().map(|datagram| datagram.by_clock(self.began))
    }

    fn send(&mut self, to: SocketAddr, bytes: &[u8]) -> io::Result<()> {
        self.connection.as_ref().ok_or(ErrorKind::NotConnected)?.1.send(to, bytes)
    }

    fn wait(&mut self) {
        std::thread::sleep(LOOK);
    }
}
