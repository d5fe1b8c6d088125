//! Names of processes: short, plain, copied without allocation.

use core::fmt;

use crate::console::quoted;
use crate::model::wire::{BadWords, Wire};

/// The longest name of a robot or a sensor \[bytes\].
pub const MAX_NAME: usize = 24;

/// What stands between the name of a lower cell and that of what is in it.
const WITHIN: char = '.';

/// The name of a robot or a virtual sensor, as the cell gives it: 1 to 24 bytes of `a-z A-Z 0-9 _ -`. What is in a lower cell has
/// the name of that cell before its own, `press.arm`.
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct Name {
    bytes: [u8; MAX_NAME],
    len: u8,
}

/// Whether this is the name of what is in a lower cell, such as `press.arm`, in the layout of the cell above.
#[must_use]
pub fn is_in_lower_cell(name: &str) -> bool {
    name.contains(WITHIN)
}

/// A text that is no [`Name`].
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("`{}` is no name: write 1 to 24 of the characters a-z A-Z 0-9 _ -, and none of the hyphens first", quoted(.0, 60))]
pub struct BadName(pub String);

impl Name {
    /// Checks and takes a name.
    ///
    /// # Errors
    /// [`BadName`] when the text is empty, too long or holds other characters.
    pub fn new(text: &str) -> Result<Name, BadName> {
        if is_in_lower_cell(text) { Err(BadName(text.to_owned())) } else { Name::of_process(text) }
    }

    /// The same, of a process that may be one of a lower cell.
    ///
    /// # Errors
    /// [`BadName`] when a part of the text is no name, or all of it is too long.
    pub fn of_process(text: &str) -> Result<Name, BadName> {
        let is_plain = |part: &str| {
            let plain = |b: u8| b.is_ascii_alphanumeric() || b == b'_' || b == b'-';
            // One that begins with a hyphen would be an option on a command line.
            !part.is_empty() && !part.starts_with('-') && part.bytes().all(plain)
        };
        if !text.split(WITHIN).all(is_plain) || text.len() > MAX_NAME {
            return Err(BadName(text.to_owned()));
        }
        let mut bytes = [0; MAX_NAME];
        bytes[..text.len()].copy_from_slice(text.as_bytes());
        Ok(Name { bytes, len: text.len() as u8 })
    }

    /// The name of what is in a lower cell: `press.arm`.
    ///
    /// # Errors
    /// [`BadName`] when the two together are too long.
    pub fn within(self, cell: Name) -> Result<Name, BadName> {
        Name::of_process(&format!("{cell}{WITHIN}{self}"))
    }

    /// The name of the lower cell that this is in: `press` of `press.arm`.
    #[must_use]
    pub fn cell(&self) -> Option<Name> {
        self.as_str().rsplit_once(WITHIN).and_then(|(cell, _)| Name::of_process(cell).ok())
    }

    /// The name as text.
    #[must_use]
    pub fn as_str(&self) -> &str {
        core::str::from_utf8(&self.bytes[..usize::from(self.len)]).unwrap_or("?")
    }
}

impl fmt::Display for Name {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.as_str())
    }
}

impl fmt::Debug for Name {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Debug::fmt(self.as_str(), f)
    }
}

impl Wire for Name {
    const LEN: usize = MAX_NAME / 8;
    const LAYOUT: u64 = crate::model::wire::layout_hash(0, "name");

    fn put(&self, words: &mut [u64]) {
        for (word, chunk) in words.iter_mut().zip(self.bytes.chunks_exact(8)) {
            *word = chunk.iter().rev().fold(0, |word, &byte| word << 8 | u64::from(byte));
        }
    }

    fn get(words: &[u64]) -> Result<Self, BadWords> {
        let words = words.get(..Self::LEN).ok_or(BadWords)?;
        let mut bytes = [0; MAX_NAME];
        for (chunk, word) in bytes.chunks_exact_mut(8).zip(words) {
            chunk.copy_from_slice(&word.to_le_bytes());
        }
        let len = bytes.iter().position(|&b| b == 0).unwrap_or(MAX_NAME);
        core::str::from_utf8(&bytes[..len])
            .map_err(|_| BadWords)
            .and_then(|text| Name::of_process(text).map_err(|_| BadWords))
    }
}
