//! Why a drive gave up.

use core::fmt;

use crate::model::excess::Excess;
use crate::model::robot_stop::RobotStop;

/// Why a drive gave up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DriveFault {
    /// A value of one joint is beyond its limit.
    Exceeded {
        /// Index of the joint, from 0.
        joint: usize,
        /// The quantity, for the message: `"motor current"`.
        what: &'static str,
        /// The actual value, and the value allowed.
        excess: Excess,
    },
    /// The hardware does not answer.
    NoAnswer,
    /// The robot was stopped by its own controller, or by a person beside it.
    Stopped(RobotStop),
    /// Something else, for the message: `"the enabling switch is open"`.
    Other(&'static str),
}

impl DriveFault {
    /// `what` of a joint, from 0, is beyond its limit.
    #[must_use]
    pub const fn exceeded(joint: usize, what: &'static str, excess: Excess) -> Self {
        DriveFault::Exceeded { joint, what, excess }
    }

    /// The joint concerned, from 0, if it is one joint's fault.
    #[must_use]
    pub const fn joint(&self) -> Option<usize> {
        match *self {
            DriveFault::Exceeded { joint, .. } => Some(joint),
            DriveFault::NoAnswer | DriveFault::Stopped(_) | DriveFault::Other(_) => None,
        }
    }

    /// What went wrong, for the message.
    #[must_use]
    pub const fn what(&self) -> &'static str {
        match *self {
            DriveFault::Exceeded { what, .. } | DriveFault::Other(what) => what,
            DriveFault::NoAnswer => "no answer",
            DriveFault::Stopped(stop) => stop.cause().text(),
        }
    }

    /// The value that is beyond its limit, if one is.
    #[must_use]
    pub const fn excess(&self) -> Option<Excess> {
        match *self {
            DriveFault::Exceeded { excess, .. } => Some(excess),
            DriveFault::NoAnswer | DriveFault::Stopped(_) | DriveFault::Other(_) => None,
        }
    }
}

impl fmt::Display for DriveFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let DriveFault::Stopped(stop) = self {
            return stop.fmt(f);
        }
        f.write_str(self.what())?;
        match self.excess() {
            Some(excess) => {
                let Excess { actual, limit, unit } = excess;
                write!(f, ": {actual} {unit}, {} {limit} {unit}", excess.allowed())
            }
            None => Ok(()),
        }
    }
}

impl std::error::Error for DriveFault {}

impl From<RobotStop> for DriveFault {
    fn from(stop: RobotStop) -> Self {
        DriveFault::Stopped(stop)
    }
}
