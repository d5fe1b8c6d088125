//! How the drives are opened: the robot takes the connection, and says its first state.
//!
//! In: the time, the robot's answers, and its states. Out: a link to it. Nothing here has a clock or a socket.

use core::time::Duration;
use std::net::SocketAddr;

use mrroc::robot::DriveFault;

use crate::message::{Answer, State};
use crate::stops::{ABSENT, OTHER_VERSION};

/// How long to wait for the connection, then for the robot's answer, and for its first state since the beginning.
pub(crate) const TIMEOUT: Duration = Duration::from_secs(2);

/// The first state of a robot.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FirstState {
    pub said: State,
    pub from: SocketAddr,
    pub came: Duration,
}

/// Drives that are being opened.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Opening {
    /// The number of the request that is to be answered, and until when.
    asked: Option<(u32, Duration)>,
    /// Until when the first state is waited for.
    until: Duration,
}

/// What comes next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum AwaitedMessage {
    Answer,
    State,
}

impl Opening {
    /// Drives whose opening began at `began`, and which have asked for a connection now.
    pub fn new(began: Duration, now: Duration, id: u32) -> Opening {
        Opening { asked: Some((id, now + TIMEOUT)), until: began + TIMEOUT }
    }

    /// What is awaited at this time.
    ///
    /// # Errors
    /// It was awaited for long enough.
    pub fn poll(&self, now: Duration) -> Result<AwaitedMessage, DriveFault> {
        match self.asked {
            Some((_, until)) if now < until => Ok(AwaitedMessage::Answer),
            None if now < self.until => Ok(AwaitedMessage::State),
            Some(_) | None => Err(ABSENT),
        }
    }

    /// The robot answers.
    ///
    /// # Errors
    /// It speaks another version.
    pub fn answer(&mut self, answer: &Answer) -> Result<(), DriveFault> {
        let is_of = self.asked.is_some_and(|(id, _)| id == answer.id);
        if is_of && answer.status != 0 {
            return Err(OTHER_VERSION);
        }
        if is_of {
            self.asked = None;
        }
        Ok(())
    }
}
