//! What a cell reads that others wrote, and that no public function reads: for fuzzing. Nothing here is promised to stay.

use mrroc_core::link::envelope::{Envelope, Seal};
use mrroc_core::link::message::Message;

pub use mrroc_core::link::envelope::ENVELOPE_WORDS;

/// Words in shared memory, the head of a message first, of which the checksum says that they are whole.
///
/// # Panics
/// When a message that is read is written as something else.
pub fn envelope(words: &[u64]) {
    let shown = Envelope::of_words(words);
    let mut message = Message::empty();
    if shown.open(&mut message).is_ok() {
        let written = Envelope::seal(&message, Seal { session: 0, epoch: 0 }, 1);
        assert_eq!(written.words(), shown.words());
    }
}
