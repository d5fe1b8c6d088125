//! What went wrong, and what to do about it.

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

    /// The exit status that says so: 2 for what was refused, 1 otherwise.
    #[must_use]
    pub fn status(&self) -> u8 {
        match self {
            Error::Refused { .. } | Error::Usage(_) => 2,
            Error::Failed { .. } => 1,
        }
    }
}
