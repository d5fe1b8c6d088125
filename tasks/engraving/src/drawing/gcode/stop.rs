//! Why a program is not read to its end, and where.

use crate::error::{DrawingError, Place};

/// Why a block stops the reading, at which byte of its line, and in which line, from 0.
#[derive(Debug)]
pub struct Stop {
    pub byte: usize,
    pub cause: Cause,
    pub line: Option<usize>,
}

impl Stop {
    /// In this line, unless another is known.
    pub fn on(self, line: usize) -> Self {
        Self { line: self.line.or(Some(line)), ..self }
    }

    pub fn too_deep(byte: usize, what: &'static str, limit: usize) -> Self {
        Self { byte, cause: Cause::TooDeep(what, limit), line: None }
    }
}

/// A cause that does not know its place yet.
#[derive(Debug)]
pub enum Cause {
    Malformed(String, String),
    Unsupported(String, String),
    Truncated(String),
    Feed(f64),
    Mismatch(f64, f64),
    Range(String, f64),
    TooMany(usize),
    TooDeep(&'static str, usize),
    Nothing(String),
    /// The option names a word that moves no pen.
    NoPen(String),
}

impl Cause {
    pub fn at(self, at: Place) -> DrawingError {
        match self {
            Self::Malformed(what, help) => DrawingError::Malformed { at, what, help },
            Self::Unsupported(what, help) => DrawingError::Unsupported { at, what, help },
            Self::Truncated(inside) => DrawingError::Truncated { at, inside },
            Self::Feed(feed) => DrawingError::FeedNotPositive { at, feed },
            Self::Mismatch(start_mm, end_mm) => DrawingError::ArcMismatch { at, start_mm, end_mm },
            Self::Range(what, value) => DrawingError::OutOfRange { at, what, value },
            Self::TooMany(limit) => DrawingError::TooManyPieces { at, limit },
            Self::TooDeep(what, limit) => DrawingError::TooDeep { at, what, limit },
            Self::Nothing(what) | Self::NoPen(what) => {
                DrawingError::Unsupported { at, what, help: String::new() }
            }
        }
    }
}

pub fn malformed<T>(byte: usize, what: impl Into<String>, help: impl Into<String>) -> Result<T, Stop> {
    Err(Stop { byte, cause: Cause::Malformed(what.into(), help.into()), line: None })
}

pub fn unsupported<T>(byte: usize, what: impl Into<String>, help: impl Into<String>) -> Result<T, Stop> {
    Err(Stop { byte, cause: Cause::Unsupported(what.into(), help.into()), line: None })
}
