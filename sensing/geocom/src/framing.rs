//! Bytes of a serial line as lines of text.

use crate::action::GeocomError;
use crate::protocol::LONGEST;

/// Lines of text, as their bytes come: in pieces, and several at once.
#[derive(Clone, Debug, Default)]
pub struct Lines {
    begun: Vec<u8>,
    /// Empty lines since the last one that was not.
    empty: usize,
}

impl Lines {
    /// Nothing has come yet.
    #[must_use]
    pub const fn new() -> Self {
        Self { begun: Vec::new(), empty: 0 }
    }

    /// These bytes have come.
    pub fn push(&mut self, bytes: &[u8]) {
        self.begun.extend_from_slice(bytes);
    }

    /// The next line that is not empty, without its end; `None` while it has none.
    ///
    /// # Errors
    /// [`GeocomError::Garbled`] of a line without an end, which is thrown away, and of nothing but ends of lines.
    pub fn next_line(&mut self) -> Result<Option<String>, GeocomError> {
        while let Some(end) = self.begun.iter().position(|byte| matches!(byte, b'\n' | b'\r')) {
            let line: Vec<u8> = self.begun.drain(..=end).take(end).collect();
            if !line.is_empty() {
                self.empty = 0;
                return Ok(Some(String::from_utf8_lossy(&line).into_owned()));
            }
            self.empty += 1;
            if self.empty > LONGEST {
                self.empty = 0;
                return Err(GeocomError::Garbled);
            }
        }
        if self.begun.len() > LONGEST {
            self.begun.clear();
            return Err(GeocomError::Garbled);
        }
        Ok(None)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_is_read_whatever_pieces_its_bytes_come_in() {
        let mut lines = Lines::new();
        for piece in ["\r\n%R1P,0", ",1:", "0\r", "\n%R1P,0,2:0\n%R"] {
            lines.push(piece.as_bytes());
        }
        let mut next = || lines.next_line().expect("a line");
        assert_eq!(next().as_deref(), Some("%R1P,0,1:0"));
        assert_eq!(next().as_deref(), Some("%R1P,0,2:0"));
        assert_eq!(next(), None);
        lines.push(b"1P,0,3:0\r");
        assert_eq!(lines.next_line().expect("a line").as_deref(), Some("%R1P,0,3:0"));
    }

    #[test]
    fn a_line_without_an_end_and_ends_without_a_line_are_garbled() {
        let mut lines = Lines::new();
        lines.push(&[b'x'; LONGEST]);
        assert_eq!(lines.next_line(), Ok(None));
        lines.push(b"x");
        assert_eq!(lines.next_line(), Err(GeocomError::Garbled));
        // It is thrown away, so that the next one is read.
        lines.push(b"y\r");
        assert_eq!(lines.next_line(), Ok(Some("y".to_owned())));
        lines.push(&[b'\n'; LONGEST]);
        assert_eq!(lines.next_line(), Ok(None));
        lines.push(b"\n");
        assert_eq!(lines.next_line(), Err(GeocomError::Garbled));
    }
}
