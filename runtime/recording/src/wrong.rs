//! What is wrong with a recording.
//!
//! In: what a reader finds. Out: a text for a person, with what to do.

use std::path::{Path, PathBuf};

/// What to do with a recording that was cut off.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CutOff {
    /// Refuse it.
    Refused,
    /// Replay it up to the last step that is complete.
    Taken,
}

/// Why a file cannot be replayed.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{}: {what}\n help: {help}", file.display())]
pub struct NotReplayable {
    file: PathBuf,
    what: String,
    help: String,
}

/// What is wrong with a recording; the name of the file is added later.
pub(super) struct Wrong {
    what: String,
    help: &'static str,
    is_damage: bool,
}

impl Wrong {
    pub fn new(what: impl Into<String>, help: &'static str) -> Wrong {
        Wrong { what: what.into(), help, is_damage: false }
    }

    /// An error for a file that is damaged, or was cut off.
    pub fn damaged(what: impl Into<String>) -> Wrong {
        let help =
            "record the run again; what is there up to the damage can be looked at with an MCAP viewer";
        Wrong { is_damage: true, ..Wrong::new(what, help) }
    }

    /// An error for contents that only another kind of recorder can have written.
    pub fn foreign(what: impl Into<String>) -> Wrong {
        Wrong::new(what, "give a file that --record has written")
    }

    /// What is wrong.
    pub fn what(&self) -> &str {
        &self.what
    }

    /// Whether the file is damaged.
    pub const fn is_damage(&self) -> bool {
        self.is_damage
    }

    /// The same of this file.
    pub fn of(self, file: &Path) -> NotReplayable {
        NotReplayable { file: file.to_owned(), what: self.what, help: self.help.to_owned() }
    }
}

/// A file that the system does not read.
pub(super) fn unreadable(error: std::io::Error) -> Wrong {
    Wrong::new(format!("cannot be read: {error}"), "see whether it is a file, and who may read it")
}
