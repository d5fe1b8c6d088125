//! What crosses the port: one message, the same for readings and for orders.
//!
//! In: a value as words. Out: a message with a header that says what its words are, of which step, and of when; or what is
//! wrong with the message of another program. Nothing in it is reinterpreted: every bit pattern is a message, and most of
//! them are refused.

use iceoryx2::prelude::ZeroCopySend;

/// The version of this interface.
pub(crate) const VERSION: u32 = 1;

/// The name by which iceoryx2 tells this type from others: it changes when the fields do.
pub(crate) const TYPE: &str = "mrroc_external_1";

/// The words of a message.
pub(crate) const WORDS: usize = mrroc::payload::WORDS;

/// A message as it lies in shared memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(C)]
pub(crate) struct Message {
    /// [`VERSION`] of who wrote it.
    pub version: u32,
    /// How many of its words say something.
    pub len: u32,
    /// The layout of what they say: a hash of its type.
    pub layout: u64,
    /// The step of the order: of a reading, that for which it was measured, 0 if it was measured for none.
    pub step: u64,
    /// When it was measured, or ordered: `CLOCK_MONOTONIC` \[ns\].
    pub time: u64,
    pub words: [u64; WORDS],
}

#[expect(unsafe_code, reason = "it says to iceoryx2 that the type may be in shared memory")]
// SAFETY: a message consists of plain numbers in C's layout without gaps: it has no pointer and nothing to drop, and every bit
// pattern is valid.
unsafe impl ZeroCopySend for Message {
    unsafe fn type_name() -> &'static str {
        TYPE
    }
}

/// Why the message of another program is none.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Foreign {
    /// Of another version of this interface.
    Version(u32),
    /// With other fields than the reading of this sensor.
    Layout,
    /// With another number of words.
    Len(u32),
}

impl Message {
    pub const EMPTY: Message =
        Message { version: VERSION, len: 0, layout: 0, step: 0, time: 0, words: [0; WORDS] };

    /// The words of a reading of this layout.
    pub fn reading(&self, layout: u64, len: usize) -> Result<&[u64], Foreign> {
        if self.version != VERSION {
            return Err(Foreign::Version(self.version));
        }
        if self.layout != layout {
            return Err(Foreign::Layout);
        }
        let whole = self.words.get(..len).filter(|_| self.len as usize == len);
        whole.ok_or(Foreign::Len(self.len))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_layout_of_a_message_is_the_one_that_the_page_tells_to_others() {
        assert_eq!(core::mem::size_of::<Message>(), 32 + 8 * 64);
        assert_eq!(core::mem::align_of::<Message>(), 8);
        let at = |field: usize, base: usize| field - base;
        let message = Message::EMPTY;
        let base = &raw const message as usize;
        assert_eq!(at(&raw const message.version as usize, base), 0);
        assert_eq!(at(&raw const message.len as usize, base), 4);
        assert_eq!(at(&raw const message.layout as usize, base), 8);
        assert_eq!(at(&raw const message.step as usize, base), 16);
        assert_eq!(at(&raw const message.time as usize, base), 24);
        assert_eq!(at(&raw const message.words as usize, base), 32);
    }

    #[test]
    fn fault_121_a_message_of_another_version_layout_or_length_is_none() {
        let good = Message { len: 2, layout: 7, ..Message::EMPTY };
        assert_eq!(good.reading(7, 2), Ok(&[0, 0][..]));
        assert_eq!(Message { version: 2, ..good }.reading(7, 2), Err(Foreign::Version(2)));
        assert_eq!(good.reading(8, 2), Err(Foreign::Layout));
        assert_eq!(good.reading(7, 3), Err(Foreign::Len(2)));
        let far = Message { len: u32::MAX, ..good };
        assert_eq!(far.reading(7, 2), Err(Foreign::Len(u32::MAX)));
        assert_eq!(far.reading(7, u32::MAX as usize), Err(Foreign::Len(u32::MAX)));
    }
}
