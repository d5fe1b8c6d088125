//! How much a drawing may ask for: checked while reading, so that a hostile file is refused quickly.

use crate::error::{DrawingError, Place};

/// Bounds on what is read. The defaults refuse within two seconds and 256 MB whatever the file holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Longest file \[bytes\].
    pub file_bytes: u64,
    /// Longest line of G-code or DXF \[bytes\].
    pub line_bytes: usize,
    /// Most curve pieces in a drawing.
    pub pieces: usize,
    /// Deepest nesting of groups, uses, blocks or brackets.
    pub depth: usize,
}

impl Default for Limits {
    fn default() -> Self {
        Self { file_bytes: 64 << 20, line_bytes: 64 << 10, pieces: 250_000, depth: 64 }
    }
}

/// What is left of the limits while one file is read.
#[derive(Debug)]
pub struct Budget {
    limits: Limits,
    used: usize,
}

impl Budget {
    /// A fresh budget.
    #[must_use]
    pub fn new(limits: Limits) -> Self {
        Self { limits, used: 0 }
    }

    /// The limits behind it.
    #[must_use]
    pub fn limits(&self) -> &Limits {
        &self.limits
    }

    /// Takes `count` more pieces.
    ///
    /// # Errors
    /// [`DrawingError::TooManyPieces`] past the limit.
    pub fn take(&mut self, count: usize, at: impl FnOnce() -> Place) -> Result<(), DrawingError> {
        self.used = self.used.saturating_add(count);
        if self.used > self.limits.pieces {
            return Err(DrawingError::TooManyPieces { at: at(), limit: self.limits.pieces });
        }
        Ok(())
    }

    /// Refuses nesting deeper than the limit.
    ///
    /// # Errors
    /// [`DrawingError::TooDeep`] past the limit.
    pub fn depth(
        &self,
        depth: usize,
        what: &'static str,
        at: impl FnOnce() -> Place,
    ) -> Result<(), DrawingError> {
        if depth > self.limits.depth {
            return Err(DrawingError::TooDeep { at: at(), what, limit: self.limits.depth });
        }
        Ok(())
    }
}
