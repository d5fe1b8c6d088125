//! What went wrong, and what to do about it.

use std::io::{self, ErrorKind};

/// What to do about a disk that is full.
pub(crate) const FULL: &str = "the disk has no room left, or no inodes: remove what is not needed there (df, df -i), or take another folder";

/// Why nothing was made.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Error {
    /// What was asked for cannot be had; nothing was written.
    #[error("{what}\n help: {help}")]
    Refused {
        /// What is wrong.
        what: String,
        /// What to write instead.
        help: String,
    },
    /// The command line cannot be read; nothing was written. What is wrong, and how it is used.
    #[error("{}", .0.trim_start_matches("error: ").trim_end())]
    Usage(String),
    /// It was asked for rightly but did not succeed; nothing is left behind.
    #[error("{what}\n help: {help}")]
    Failed {
        /// What failed.
        what: String,
        /// What may help.
        help: String,
    },
}

impl Error {
    pub(crate) fn refused(what: impl Into<String>, help: impl Into<String>) -> Self {
        Error::Refused { what: what.into(), help: help.into() }
    }

    pub(crate) fn failed(what: impl Into<String>, help: impl Into<String>) -> Self {
        Error::Failed { what: what.into(), help: help.into() }
    }

    /// What the system refused, for `what`: a disk or a machine that is full says so itself, and else there is `help`.
    pub(crate) fn of_system(what: impl Into<String>, error: &io::Error, help: impl Into<String>) -> Self {
        let help = match error.kind() {
            ErrorKind::StorageFull => FULL.to_owned(),
            ErrorKind::QuotaExceeded => {
                "you may not store more there: remove what you do not need".to_owned()
            }
            ErrorKind::WouldBlock | ErrorKind::OutOfMemory => {
                "the machine has no room for another process: end some; see ulimit -u".to_owned()
            }
            _ => help.into(),
        };
        Error::failed(format!("{}: {error}", what.into()), help)
    }

    /// The exit status that says so: 2 for what was refused, 1 otherwise.
    #[must_use]
    pub fn status(&self) -> u8 {
        match self {
            Error::Refused { .. } | Error::Usage(_) => 2,
            Error::Failed { .. } => 1,
        }
    }
}
