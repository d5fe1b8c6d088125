//! Lines of a text file with their numbers.

use mrroc::console::quoted;

use super::error::MeshError;

/// The beginning of a text, for a message.
pub(super) fn shown(text: &str) -> String {
    format!("\"{}\"", quoted(text.trim(), 60))
}

/// The lines of a text that are not blank.
pub(super) struct Lines<'a> {
    lines: core::iter::Enumerate<core::str::Lines<'a>>,
    /// The number of the line that was given last, from 1.
    last: usize,
}

impl<'a> Lines<'a> {
    /// The lines of a file.
    pub(super) fn of(bytes: &'a [u8]) -> Result<Self, MeshError> {
        let text = core::str::from_utf8(bytes).map_err(|_| MeshError::NoText)?;
        Ok(Self { lines: text.lines().enumerate(), last: 1 })
    }

    /// The next line, and its number.
    pub(super) fn next(&mut self) -> Option<(usize, &'a str)> {
        let (number, line) = self.lines.find(|(_, line)| !line.trim().is_empty())?;
        self.last = number + 1;
        Some((self.last, line))
    }

    /// The next line, which must consist of these words, in any case.
    pub(super) fn expect(&mut self, words: &[&str], expected: &'static str) -> Result<(), MeshError> {
        let (line, found) = self.next().ok_or_else(|| self.cut_off(expected))?;
        if found.split_ascii_whitespace().eq(words.iter().copied()) {
            return Ok(());
        }
        Err(MeshError::Text { line, found: shown(found), expected })
    }

    /// The error of a text that ends too early.
    pub(super) fn cut_off(&self, expected: &'static str) -> MeshError {
        MeshError::CutOff { line: self.last, expected }
    }
}

/// Three numbers at the beginning of these words.
pub(super) fn three<'a>(words: &mut impl Iterator<Item = &'a str>) -> Option<[f64; 3]> {
    let mut numbers = [0.0; 3];
    for number in &mut numbers {
        *number = words.next()?.parse().ok()?;
    }
    Some(numbers)
}
