//! The calibration, from the primary interface: the controller tells it to whoever calls.
//!
//! In: the time, and the messages that come. Out: the calibration. Nothing here has a clock or a socket.

use core::time::Duration;

use mrroc_driver_kit::Cutting;

use super::ConnectionLost;
use crate::calibration::Calibration;
use crate::primary::{calibration, message_length};

/// How long a controller may take to answer the call, and then to tell it.
pub(super) const TIMEOUT: Duration = Duration::from_secs(2);

/// Nobody has answered the call.
pub(super) const ABSENT: ConnectionLost =
    ConnectionLost("nobody answers at its primary interface: is it switched on?");

/// How the stream is cut into messages.
pub(super) fn cut(bytes: &[u8]) -> Cutting {
    match message_length(bytes) {
        Ok(Some(length)) => Cutting::Frame(length),
        Ok(None) => Cutting::More,
        Err(_) => Cutting::Bad,
    }
}

/// The calibration of a controller that was called; it is waited for until this time.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reading(Duration);

impl Reading {
    /// From now on.
    pub(super) fn new(now: Duration) -> Reading {
        Reading(now + TIMEOUT)
    }

    /// The calibration, if this message has it. What came before the end of the connection is read, too.
    ///
    /// # Errors
    /// It is told no more.
    pub(super) fn poll(
        &self,
        now: Duration,
        message: Option<&[u8]>,
        is_open: bool,
    ) -> Result<Option<Calibration>, ConnectionLost> {
        match message {
            Some(message) => Ok(calibration(message)),
            None if is_open && now <= self.0 => Ok(None),
            None => {
                Err(ConnectionLost("the controller does not tell its calibration at its primary interface"))
            }
        }
    }
}
