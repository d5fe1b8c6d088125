//! A text that a fault carries without an allocation of its own.

/// A short text that travels with a fault: what the program or a panic said, cut at 120 bytes.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) struct Text {
    pub bytes: [u8; 120],
    pub len: u8,
}

impl Text {
    pub fn new(text: &str) -> Text {
        let text = Text::cut(text, 120);
        let mut bytes = [0; 120];
        bytes[..text.len()].copy_from_slice(text.as_bytes());
        Text { bytes, len: text.len() as u8 }
    }

    /// As much of a text as has so many bytes.
    pub fn cut(text: &str, bytes: usize) -> &str {
        let mut len = text.len().min(bytes);
        while !text.is_char_boundary(len) {
            len -= 1;
        }
        &text[..len]
    }

    pub fn as_str(&self) -> &str {
        core::str::from_utf8(&self.bytes[..usize::from(self.len)]).unwrap_or("")
    }
}
