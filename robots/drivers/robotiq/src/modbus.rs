//! Messages of Modbus TCP: a question about a few registers, and its answer.
//!
//! In: which registers to write or to read; the bytes that came. Out: the bytes of a question; registers, or why those bytes
//! are no answer to it. Nothing is allocated, and no frame may be longer than the protocol allows.

/// The most bytes that a frame may have: 7 of the header, and 253 of the message in it.
pub const MAX_FRAME: usize = 260;

/// Bytes before the message: transaction, protocol, length, unit.
const HEADER: usize = 7;

/// Registers that a question may be about. The protocol allows 123; a gripper has three each way.
pub const MAX_REGISTERS: usize = 8;

/// Why what came is no answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NoAnswer {
    /// The protocol is not 0.
    #[error("the answer is of another protocol")]
    Protocol,
    /// The length is none of a message, or of another answer than was asked for.
    #[error("the answer has a length that cannot be")]
    Length,
    /// It is an answer to another question.
    #[error("the answer has another transaction's number")]
    Transaction,
    /// It is of another unit.
    #[error("the answer is of another unit")]
    Unit,
    /// It has another function, or is about other registers.
    #[error("the answer is to another question")]
    Question,
    /// The device refuses, with this code of an exception.
    #[error("{}", exception(*.0))]
    Exception(u8),
}

impl NoAnswer {
    /// The same as a text that lasts.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            NoAnswer::Protocol => "the answer is of another protocol than Modbus",
            NoAnswer::Length => "the answer has a length that cannot be",
            NoAnswer::Transaction => "the answer has another transaction's number",
            NoAnswer::Unit => "the answer is of another unit",
            NoAnswer::Question => "the answer is to another question",
            NoAnswer::Exception(code) => exception(code),
        }
    }

    /// Whether the same question may be asked again: the device is busy, or a gateway has not heard it this time.
    #[must_use]
    pub const fn passes(self) -> bool {
        matches!(self, NoAnswer::Exception(5 | 6 | 0x0b))
    }
}

/// What an exception says, by its code (Modbus Application Protocol 1.1b3, section 7).
const fn exception(code: u8) -> &'static str {
    match code {
        1 => "exception 1: the device does not know the function",
        2 => "exception 2: the device has no such registers",
        3 => "exception 3: the device does not take the value",
        4 => "exception 4: the device has failed",
        5 => "exception 5: the device needs longer",
        6 => "exception 6: the device is busy",
        8 => "exception 8: the device's memory is damaged",
        0x0a => "exception 10: the gateway has no way to the device",
        0x0b => "exception 11: the device does not answer its gateway",
        _ => "an exception with a code that is none",
    }
}

/// A question to a unit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Question {
    /// The number by which the answer is known.
    pub transaction: u16,
    /// The unit behind the address: that of a device on a serial line behind a gateway.
    pub unit: u8,
    /// What is asked.
    pub what: Asked,
}

/// What is asked of a unit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Asked {
    /// Write these registers, from this one on (function 16).
    Write(u16, [u16; 3]),
    /// Read so many input registers, from this one on (function 4), at most [`MAX_REGISTERS`].
    Read(u16, u16),
}

impl Asked {
    const fn function(self) -> u8 {
        match self {
            Asked::Write(..) => 0x10,
            Asked::Read(..) => 0x04,
        }
    }
}

/// The bytes of a question.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Bytes {
    bytes: [u8; 19],
    len: usize,
}

impl Bytes {
    /// They.
    #[must_use]
    pub fn as_slice(&self) -> &[u8] {
        &self.bytes[..self.len]
    }

    fn push(&mut self, more: &[u8]) {
        self.bytes[self.len..self.len + more.len()].copy_from_slice(more);
        self.len += more.len();
    }
}

/// The registers of an answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Registers {
    words: [u16; MAX_REGISTERS],
    len: usize,
}

impl Registers {
    /// They; none after a question that writes.
    #[must_use]
    pub fn as_slice(&self) -> &[u16] {
        &self.words[..self.len]
    }
}

impl Question {
    /// The frame to send.
    #[must_use]
    pub fn bytes(&self) -> Bytes {
        let mut frame = Bytes { bytes: [0; 19], len: 0 };
        // Bytes that follow the length: the unit, and the message.
        let length: u16 = match self.what {
            Asked::Write(_, words) => 7 + 2 * words.len() as u16,
            Asked::Read(..) => 6,
        };
        for word in [self.transaction, 0, length] {
            frame.push(&word.to_be_bytes());
        }
        frame.push(&[self.unit, self.what.function()]);
        match self.what {
            Asked::Write(first, words) => {
                frame.push(&first.to_be_bytes());
                frame.push(&[0, words.len() as u8, 2 * words.len() as u8]);
                words.iter().for_each(|word| frame.push(&word.to_be_bytes()));
            }
            Asked::Read(first, count) => {
                frame.push(&first.to_be_bytes());
                frame.push(&count.to_be_bytes());
            }
        }
        frame
    }

    /// Reads what came: the registers when the whole answer is there, and `None` while more must come.
    ///
    /// # Errors
    /// It is not the answer, or a refusal.
    pub fn answer(&self, came: &[u8]) -> Result<Option<Registers>, NoAnswer> {
        let word = |at: usize| Some(u16::from_be_bytes([*came.get(at)?, *came.get(at + 1)?]));
        let (Some(transaction), Some(protocol), Some(length)) = (word(0), word(2), word(4)) else {
            return Ok(None);
        };
        if protocol != 0 {
            return Err(NoAnswer::Protocol);
        }
        // The unit, a function and a byte are the least.
        let whole = HEADER - 1 + usize::from(length);
        if length < 3 || whole > MAX_FRAME || came.len() > whole {
            return Err(NoAnswer::Length);
        }
        if transaction != self.transaction {
            return Err(NoAnswer::Transaction);
        }
        if came.len() < whole {
            return Ok(None);
        }
        if came[6] != self.unit {
            return Err(NoAnswer::Unit);
        }
        let (function, message) = (came[7], &came[8..]);
        if function == self.what.function() | 0x80 && message.len() == 1 {
            return Err(NoAnswer::Exception(message[0]));
        }
        if function != self.what.function() {
            return Err(NoAnswer::Question);
        }
        self.registers(message).map(Some)
    }

    fn registers(&self, message: &[u8]) -> Result<Registers, NoAnswer> {
        let mut registers = Registers { words: [0; MAX_REGISTERS], len: 0 };
        match self.what {
            Asked::Write(first, words) => {
                let echo = [first.to_be_bytes(), (words.len() as u16).to_be_bytes()];
                match message.len() {
                    4 if message == echo.as_flattened() => Ok(registers),
                    4 => Err(NoAnswer::Question),
                    _ => Err(NoAnswer::Length),
                }
            }
            Asked::Read(_, count) => {
                let count = usize::from(count);
                let words = message.split_first().filter(|(bytes, words)| {
                    usize::from(**bytes) == words.len() && words.len() == 2 * count && count <= MAX_REGISTERS
                });
                let (_, words) = words.ok_or(NoAnswer::Length)?;
                for (to, word) in registers.words.iter_mut().zip(words.chunks_exact(2)) {
                    *to = u16::from_be_bytes([word[0], word[1]]);
                }
                registers.len = count;
                Ok(registers)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const READ: Question = Question { transaction: 0xd605, unit: 2, what: Asked::Read(0, 3) };
    const WRITE: Question =
        Question { transaction: 0x34ab, unit: 2, what: Asked::Write(0, [0x0900, 0x00ff, 0xffff]) };
    const READING: [u8; 15] = [0xd6, 5, 0, 0, 0, 9, 2, 4, 6, 0xf9, 0, 0, 0, 0x0d, 0];

    /// Frames that the manual of the manufacturer's 200 mm gripper prints (pages 77 to 79).
    #[test]
    fn questions_and_answers_are_those_of_the_manufacturers_manual() {
        assert_eq!(READ.bytes().as_slice(), [0xd6, 5, 0, 0, 0, 6, 2, 4, 0, 0, 0, 3]);
        assert_eq!(
            WRITE.bytes().as_slice(),
            [0x34, 0xab, 0, 0, 0, 13, 2, 16, 0, 0, 0, 3, 6, 9, 0, 0, 0xff, 0xff, 0xff]
        );
        let written = WRITE.answer(&[0x34, 0xab, 0, 0, 0, 6, 2, 16, 0, 0, 0, 3]);
        assert_eq!(written.map(|answer| answer.map(|answer| answer.as_slice().len())), Ok(Some(0)));
        let read = READ.answer(&READING).expect("an answer").expect("whole");
        assert_eq!(read.as_slice(), [0xf900, 0, 0x0d00]);
    }

    #[test]
    fn an_answer_may_come_in_pieces() {
        for len in 0..READING.len() {
            assert_eq!(READ.answer(&READING[..len]), Ok(None), "{len} bytes");
        }
    }

    #[test]
    fn fault_102_what_is_not_the_answer_is_refused_by_its_reason() {
        let with = |at: usize, byte: u8| {
            let mut bytes = READING;
            bytes[at] = byte;
            READ.answer(&bytes)
        };
        assert_eq!(with(0, 0xd7), Err(NoAnswer::Transaction));
        assert_eq!(with(3, 1), Err(NoAnswer::Protocol));
        assert_eq!(with(4, 0xff), Err(NoAnswer::Length));
        assert_eq!(with(5, 2), Err(NoAnswer::Length));
        assert_eq!(with(5, 8), Err(NoAnswer::Length), "there is more than it says");
        assert_eq!(with(5, 10), Ok(None), "there is less than it says");
        assert_eq!(with(6, 9), Err(NoAnswer::Unit));
        assert_eq!(with(7, 3), Err(NoAnswer::Question));
        assert_eq!(with(8, 4), Err(NoAnswer::Length));
        let refused = [0xd6, 5, 0, 0, 0, 3, 2, 0x84, 2];
        assert_eq!(READ.answer(&refused), Err(NoAnswer::Exception(2)));
        assert_eq!(NoAnswer::Exception(2).to_string(), "exception 2: the device has no such registers");
        assert!(!NoAnswer::Exception(2).passes() && NoAnswer::Exception(11).passes());
        // Other registers than were written.
        assert_eq!(WRITE.answer(&[0x34, 0xab, 0, 0, 0, 6, 2, 16, 0, 1, 0, 3]), Err(NoAnswer::Question));
    }
}
