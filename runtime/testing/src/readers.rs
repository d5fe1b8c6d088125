//! Reads what a cell gets from other processes and no public function reads, for fuzzing. Not part of the stable
//! interface.

use mrroc_core::link::envelope::{Envelope, Seal};
use mrroc_core::link::message::Message;

pub use mrroc_core::link::envelope::ENVELOPE_WORDS;

/// Reads words of shared memory, the header first, as a message with a correct checksum.
///
/// # Panics
/// If a message that was read is written as something else.
pub fn envelope(words: &[u64]) {
    let shown = Envelope::of_words(words);
    let mut message = Message::empty();
    if shown.open(&mut message).is_ok() {
        let written = Envelope::seal(&message, Seal { session: 0, epoch: 0 }, 1);
        assert_eq!(written.words(), shown.words());
    }
}
