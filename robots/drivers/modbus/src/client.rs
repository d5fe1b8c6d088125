//! A connection with a device that speaks Modbus TCP. It blocks, so it belongs to a thread of its own.
//!
//! In: questions. Out: answers, within a time that is declared here, or why there are none.

#![expect(
    clippy::disallowed_methods,
    reason = "an answer that does not come is waited for by this machine's clock"
)]

use core::time::Duration;
use std::io::{ErrorKind, Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::time::Instant;

use mrroc::robot::{DriveFault, RobotStop, StopCause};

use crate::message::{Answer, Asked, MAX_FRAME, NoAnswer, Question};

/// How long a device may take to accept the connection.
pub const CONNECT: Duration = Duration::from_secs(1);

/// The least time that a read may wait.
const LEAST: Duration = Duration::from_millis(1);

/// Why there is no answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Broken {
    /// Nobody accepts the connection.
    #[error("nothing accepts a connection at its address")]
    Unreachable,
    /// It was closed by the other end.
    #[error("the connection was closed")]
    Closed,
    /// The answer did not come in time.
    #[error("no answer came in time")]
    Silent,
    /// What came is no answer.
    #[error(transparent)]
    NoAnswer(#[from] NoAnswer),
}

impl Broken {
    /// The same as a text that lasts.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Broken::Unreachable => "nothing accepts a connection at its address",
            Broken::Closed => "the connection was closed",
            Broken::Silent => "no answer came in time",
            Broken::NoAnswer(why) => why.name(),
        }
    }
}

/// A connection that is lost, by its name.
#[must_use]
pub const fn lost(name: &'static str) -> DriveFault {
    DriveFault::Stopped(RobotStop::new(StopCause::CommunicationLost).named(name))
}

impl From<Broken> for DriveFault {
    fn from(broken: Broken) -> DriveFault {
        match broken {
            // It is connected well, and is another device, or not the unit that was said.
            Broken::NoAnswer(why @ NoAnswer::Exception(_)) if !why.passes() => DriveFault::Other(why.name()),
            _ => lost(broken.name()),
        }
    }
}

/// The connection.
#[derive(Debug)]
pub struct Client {
    socket: TcpStream,
    unit: u8,
    /// How long the whole answer to a question may take.
    patience: Duration,
    transaction: u16,
}

impl Client {
    /// Connects to a unit, whose whole answer to a question may take so long.
    ///
    /// # Errors
    /// [`Broken::Unreachable`].
    pub fn connect(address: SocketAddr, unit: u8, patience: Duration) -> Result<Client, Broken> {
        let socket = TcpStream::connect_timeout(&address, CONNECT).map_err(|_| Broken::Unreachable)?;
        let ready = socket.set_nodelay(true).and_then(|()| socket.set_write_timeout(Some(patience)));
        ready.map_err(|_| Broken::Unreachable)?;
        Ok(Client { socket, unit, patience, transaction: 0 })
    }

    /// The socket, to be shut down while this waits for an answer.
    #[must_use]
    pub fn socket(&self) -> Option<TcpStream> {
        self.socket.try_clone().ok()
    }

    /// Asks, and waits for the answer.
    ///
    /// # Errors
    /// Why there is none. Only after a refusal that [passes](NoAnswer::passes) may something be asked again.
    pub fn ask(&mut self, what: Asked) -> Result<Answer, Broken> {
        self.transaction = self.transaction.wrapping_add(1);
        let question = Question { transaction: self.transaction, unit: self.unit, what };
        let until = Instant::now() + self.patience;
        self.socket.write_all(question.bytes().as_slice()).map_err(broken)?;
        let (mut came, mut len) = ([0; MAX_FRAME + 1], 0);
        loop {
            // A thread that was not given any time reads once more what has come in the meantime.
            let left = until.saturating_duration_since(Instant::now());
            self.socket.set_read_timeout(Some(left.max(LEAST))).map_err(broken)?;
            len += match self.socket.read(&mut came[len..]) {
                Ok(0) => return Err(Broken::Closed),
                Ok(more) => more,
                Err(why) if why.kind() == ErrorKind::Interrupted => 0,
                Err(why) => return Err(broken(why)),
            };
            if let Some(answer) = question.answer(&came[..len])? {
                return Ok(answer);
            }
            if left.is_zero() {
                return Err(Broken::Silent);
            }
        }
    }
}

fn broken(why: std::io::Error) -> Broken {
    match why.kind() {
        ErrorKind::WouldBlock | ErrorKind::TimedOut => Broken::Silent,
        _ => Broken::Closed,
    }
}
