//! What a cell reads that others wrote, and that no public function reads: for fuzzing. Nothing here is promised to stay.

use mrroc_core::link::envelope::{Envelope, Seal};
use mrroc_core::link::message::Message;

pub use mrroc_core::link::envelope::ENVELOPE_WORDS;

/// What an operator's console writes to a cell's desk, and what the desk writes to it.
///
/// # Panics
/// When what was read is written as something else, or an answer is more than a line.
#[cfg(all(feature = "processes", target_os = "linux"))]
pub fn operator(bytes: &[u8]) {
    use mrroc_processes::{Heard, MAX_REQUEST, Request};
    // The desk reads no longer ones.
    for line in bytes.split(|byte| *byte == b'\n').filter(|line| line.len() <= MAX_REQUEST) {
        match Request::read(line) {
            Ok(request) => assert_eq!(Request::read(request.to_string().as_bytes()), Ok(request)),
            Err(refused) => assert!(!refused.is_empty() && !refused.contains('\n'), "{refused}"),
        }
    }
    let mut rest = bytes;
    while let Ok(Some(heard)) = Heard::read(&mut rest) {
        if let Heard::Picture(picture) = heard {
            let text = picture.to_string();
            let again = Heard::read(&mut text.as_bytes());
            let is_same = matches!(&again, Ok(Some(Heard::Picture(again))) if again.to_string() == text);
            assert!(is_same, "{again:?} of {text}");
        }
    }
}

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

/// A recording of this cell.
///
/// # Errors
/// What is wrong with it.
#[cfg(feature = "recording")]
pub fn recording(cell: &mrroc_core::Cell, bytes: &[u8]) -> Result<(), String> {
    use mrroc_recording::{CutOff, read_bytes};
    let layout = cell.layout();
    let read = |cut_off| read_bytes(bytes, &layout, cut_off).map(drop).map_err(|wrong| wrong.to_string());
    read(CutOff::Taken).and_then(|()| read(CutOff::Refused))
}
