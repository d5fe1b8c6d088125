//! What crosses the network: the message of the port, and before it some words on who sends it and when.
//!
//! In: bytes of anybody with the sensor's certificate. Out: a message, or that it is none. Of an order: whose readings count
//! (a program's number, 0 for nobody's), and when it was sent, by this machine's clock \[ns\]. Of a reading: the
//! program's number, of the newest order that it has got the time at which it was sent, and when that came by its own clock.

use crate::message::{Message, WORDS};

/// The bytes of a message.
pub(crate) const MESSAGE: usize = 32 + 8 * WORDS;

/// What comes from a program.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct ProgramMessage {
    /// The program's number.
    pub program: u64,
    /// When the newest order was sent that it has got; 0 if it has got none.
    pub sent: u64,
    /// When that came, by its clock.
    pub came: u64,
    /// What it sends; `None` if it is no message of this port.
    pub message: Option<Message>,
}

impl ProgramMessage {
    /// Reads what has come; `None` if it does not even say who it comes from.
    pub fn read(bytes: &[u8]) -> Option<ProgramMessage> {
        let (head, message) = bytes.split_first_chunk::<24>()?;
        let word =
            |at: usize| head[at..at + 8].iter().rev().fold(0, |word, &byte| word << 8 | u64::from(byte));
        Some(ProgramMessage { program: word(0), sent: word(8), came: word(16), message: read(message) })
    }
}

/// What is sent while there is no order, so that a program can say how far its clock is away.
pub(crate) fn no_order(holder: u64, sent: u64) -> [u8; 16] {
    let mut bytes = [0; 16];
    bytes[..8].copy_from_slice(&holder.to_le_bytes());
    bytes[8..].copy_from_slice(&sent.to_le_bytes());
    bytes
}

/// The bytes of an order.
pub(crate) fn order(holder: u64, sent: u64, message: &Message) -> [u8; 16 + MESSAGE] {
    let mut bytes = [0; 16 + MESSAGE];
    let halves = [holder, sent, u64::from(message.version) | u64::from(message.len) << 32];
    let words = halves.into_iter().chain([message.layout, message.step, message.time]).chain(message.words);
    for (bytes, word) in bytes.chunks_exact_mut(8).zip(words) {
        bytes.copy_from_slice(&word.to_le_bytes());
    }
    bytes
}

/// The message of these bytes, if they are as many as those of a message.
fn read(bytes: &[u8]) -> Option<Message> {
    let bytes: &[u8; MESSAGE] = bytes.try_into().ok()?;
    let mut words = bytes
        .chunks_exact(8)
        .map(|word| word.iter().rev().fold(0_u64, |word, &byte| word << 8 | u64::from(byte)));
    let mut next = || words.next().unwrap_or_default();
    let (first, layout, step, time) = (next(), next(), next(), next());
    let words = core::array::from_fn(|_| next());
    Some(Message { version: first as u32, len: (first >> 32) as u32, layout, step, time, words })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_message_has_the_same_bytes_on_the_network_as_in_shared_memory() {
        let message = Message {
            version: 1,
            len: 0x0203,
            layout: 0x0405_0607_0809_0A0B,
            step: 12,
            time: u64::MAX - 1,
            words: core::array::from_fn(|i| (i as u64) << 56 | 0xFE),
        };
        let bytes = order(5, 6, &message);
        // By offsets of the page, little-endian, after two words.
        assert_eq!(bytes[..16], no_order(5, 6));
        assert_eq!(bytes[..16], [[5, 0, 0, 0, 0, 0, 0, 0], [6, 0, 0, 0, 0, 0, 0, 0]].concat());
        assert_eq!(bytes[16..24], [1, 0, 0, 0, 3, 2, 0, 0]);
        assert_eq!(bytes[24], 0x0B);
        assert_eq!(bytes[16 + 32 + 8 * 63..], [0xFE, 0, 0, 0, 0, 0, 0, 63]);
        let mut said = [7_u64, 8, 9].map(u64::to_le_bytes).concat();
        said.extend_from_slice(&bytes[16..]);
        assert_eq!(
            ProgramMessage::read(&said),
            Some(ProgramMessage { program: 7, sent: 8, came: 9, message: Some(message) })
        );
    }

    #[test]
    fn fault_157_bytes_of_another_number_are_no_message() {
        assert_eq!(ProgramMessage::read(&[0; 23]), None);
        for size in [24, 24 + MESSAGE - 1, 24 + MESSAGE + 1] {
            assert_eq!(ProgramMessage::read(&vec![0; size]).map(|said| said.message), Some(None), "{size}");
        }
    }
}
