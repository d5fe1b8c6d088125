//! The network in which a controller is, and its clock.
//!
//! In: whom to call, where to listen, what to send. Out: connections, what comes over them, and for how long it has been here. [`Tcp`] is
//! the real one. A test hands in a model of a controller with a clock of its own, so that it runs in no time and is the same each time.

#![expect(clippy::disallowed_methods, reason = "the one place where the drives meet sockets and a clock")]

use core::time::Duration;
use std::io;
use std::net::{IpAddr, SocketAddr};
use std::sync::mpsc::{Receiver, TryRecvError, channel};
use std::time::Instant;

use mrroc_driver_kit::{Cut, Frame, Line, RefusedCounts, RobotListener};

/// A frame that has come.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Received<'a> {
    /// What it says.
    pub bytes: &'a [u8],
    /// How long it has been here.
    pub age: Duration,
}

/// A connection. Nothing here waits.
pub trait Connection {
    /// The oldest frame that has not been read.
    fn oldest(&mut self) -> Option<Received<'_>>;

    /// Whether the other end may still say something, beyond what has come and is not read.
    fn is_open(&self) -> bool;

    /// Sends all of `bytes`, or closes the connection: what the other end does not take at once is too late.
    ///
    /// # Errors
    /// It is closed. [`WouldBlock`](io::ErrorKind::WouldBlock): the network takes no more.
    fn send(&mut self, bytes: &[u8]) -> io::Result<()>;
}

/// A port of this machine, at which one address may call, with one connection at a time. Nothing here waits.
pub trait Listener {
    /// Its connections.
    type Connection: Connection;

    /// The address and the port: the one that was found, where 0 was asked for.
    fn address(&self) -> SocketAddr;

    /// The next connection, if one has come.
    fn accept(&mut self) -> Option<Self::Connection>;

    /// What was not taken so far.
    fn refused(&self) -> RefusedCounts;
}

/// A network with one controller in it, and a clock.
pub trait Network {
    /// A connection with the controller.
    type Connection: Connection;
    /// A call of the controller that goes on.
    type Call;
    /// A port at which the controller calls.
    type Listener: Listener<Connection = Self::Connection>;

    /// The time since some beginning, which is always the same one. It never goes back.
    fn now(&self) -> Duration;

    /// Begins to call the controller at this address, for at most `timeout`. It returns at once. `cut` is how its stream is cut into frames.
    fn call(&mut self, to: SocketAddr, timeout: Duration, cut: Cut) -> Self::Call;

    /// The connection, or why there is none, once that is known; that is told once. It returns at once.
    fn called(&mut self, call: &mut Self::Call) -> Option<io::Result<Self::Connection>>;

    /// Listens at this address of this machine, for calls of `robot` alone.
    ///
    /// # Errors
    /// The address is none of this machine, or its port is taken.
    fn listen(&mut self, at: SocketAddr, robot: IpAddr, cut: Cut) -> io::Result<Self::Listener>;

    /// Lets so much time pass: called only while the cell does not run.
    fn wait(&mut self, time: Duration);
}

/// The network of this machine, and its clock.
#[derive(Debug)]
pub struct Tcp {
    began: Instant,
}

impl Tcp {
    /// With a clock that begins now.
    #[must_use]
    pub fn new() -> Tcp {
        Tcp { began: Instant::now() }
    }
}

impl Default for Tcp {
    fn default() -> Tcp {
        Tcp::new()
    }
}

/// A connection over a socket.
#[derive(Debug)]
pub struct TcpConnection {
    line: Line,
    last: Option<Frame>,
}

impl Connection for TcpConnection {
    fn oldest(&mut self) -> Option<Received<'_>> {
        self.last = Some(self.line.oldest()?);
        let frame = self.last.as_ref()?;
        Some(Received { bytes: frame.bytes(), age: frame.age() })
    }

    fn is_open(&self) -> bool {
        self.line.is_open()
    }

    fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.line.send(bytes)
    }
}

/// A listening socket.
#[derive(Debug)]
pub struct TcpPort(RobotListener);

impl Listener for TcpPort {
    type Connection = TcpConnection;

    fn address(&self) -> SocketAddr {
        self.0.address()
    }

    fn accept(&mut self) -> Option<TcpConnection> {
        self.0.answer().map(|line| TcpConnection { line, last: None })
    }

    fn refused(&self) -> RefusedCounts {
        self.0.refused()
    }
}

/// A call that is made by a thread of its own, which may wait.
#[derive(Debug)]
pub struct TcpCall(Receiver<io::Result<Line>>);

impl Network for Tcp {
    type Connection = TcpConnection;
    type Call = TcpCall;
    type Listener = TcpPort;

    fn now(&self) -> Duration {
        self.began.elapsed()
    }

    fn call(&mut self, to: SocketAddr, timeout: Duration, cut: Cut) -> TcpCall {
        let (sender, called) = channel();
        let thread = std::thread::Builder::new().name("controller".to_owned());
        // Nobody may ask for the outcome any more; and without a thread nobody sends one, which is told as an error.
        drop(thread.spawn(move || drop(sender.send(Line::call(to, timeout, cut)))));
        TcpCall(called)
    }

    fn called(&mut self, call: &mut TcpCall) -> Option<io::Result<TcpConnection>> {
        match call.0.try_recv() {
            Ok(called) => Some(called.map(|line| TcpConnection { line, last: None })),
            Err(TryRecvError::Empty) => None,
            Err(TryRecvError::Disconnected) => Some(Err(io::ErrorKind::NotConnected.into())),
        }
    }

    fn listen(&mut self, at: SocketAddr, robot: IpAddr, cut: Cut) -> io::Result<TcpPort> {
        RobotListener::open(at, robot, cut).map(TcpPort)
    }

    fn wait(&mut self, time: Duration) {
        std::thread::sleep(time);
    }
}
