//! What a client needs next, and what it ends with: what was measured, or why nothing was.

use core::time::Duration;

use crate::angles::Face;
use crate::protocol::Code;

/// What a client needs before it goes on.
#[derive(Clone, Copy, Debug, PartialEq)]
#[must_use]
pub enum ClientAction {
    /// Send what is [`outgoing`](crate::Client::outgoing), or a part of it, and [poll](crate::Client::poll) again with nothing: then, or at this time at the latest.
    Send {
        /// By the same clock as polls.
        until: Duration,
    },
    /// Poll again with what comes, as soon as it does; with nothing, at this time. What has come and was not read yet is read before nothing is said to
    /// have come.
    Receive {
        /// By the same clock as polls; it may be over already.
        until: Duration,
    },
    /// It is done: what was measured, if that was asked for.
    Done(Result<Option<Measured>, GeocomError>),
    /// Nothing was asked for.
    Idle,
}

/// What was measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measured {
    /// Horizontal angle from x to y, -pi to pi, and elevation \[rad\], both as of the first face.
    pub angles: [f64; 2],
    /// In which face.
    pub face: Face,
}

/// Why an exchange with the instrument failed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum GeocomError {
    /// No answer came, however often it was asked.
    #[error("no answer came in time: is the instrument on, and the speed of the port its own?")]
    Silent,
    /// No answer could be understood.
    #[error("no answer could be understood: compare the speed of the port, and shorten the cable")]
    Garbled,
    /// The instrument says what is wrong.
    #[error("the instrument answers {}: {}", .0.0, .0.meaning())]
    Refused(Code),
    /// The telescope is not in the face that was asked for.
    #[error("the telescope is in the other face than was asked for: leave it alone")]
    OtherFace,
    /// The line is closed.
    #[error("the serial port is closed: is its cable in?")]
    Closed,
}

impl GeocomError {
    /// Whether it may be another time.
    pub(crate) const fn is_passing(self) -> bool {
        match self {
            Self::Silent | Self::Garbled => true,
            Self::Refused(code) => code.is_busy(),
            Self::OtherFace | Self::Closed => false,
        }
    }
}
