//! Messages of Modbus TCP: a question about a few bits or registers, and its answer.
//!
//! In: what to write or to read; the bytes that came. Out: the bytes of a question; bits or registers, or why those bytes are no answer
//! to it. Nothing is allocated, and no frame may be longer than the protocol allows. (Modbus Application Protocol 1.1b3.)

/// The most bytes that a frame may have: 7 of the header, and 253 of the message in it.
pub const MAX_FRAME: usize = 260;

/// Bytes before the message: transaction, protocol, length, unit.
const HEADER: usize = 7;

/// Registers that a question may be about. The protocol allows 123; no driver here needs more.
pub const MAX_REGISTERS: usize = 8;

/// Bits that a question may be about. The protocol allows 2000.
pub const MAX_BITS: u16 = 32;

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

    /// The exception of a gateway that has given up a question: its answer may still come.
    pub(crate) const GATEWAY: u8 = 0x0b;

    /// Whether the same question may be asked again: the device is busy, or a gateway has not heard it this time.
    #[must_use]
    pub const fn passes(self) -> bool {
        matches!(self, NoAnswer::Exception(5 | 6 | NoAnswer::GATEWAY))
    }
}

/// What an exception says, by its code (Modbus Application Protocol 1.1b3, section 7).
const fn exception(code: u8) -> &'static str {
    match code {
        1 => "exception 1: the device does not know the function",
        2 => "exception 2: the device has no such bits or registers",
        3 => "exception 3: the device does not take the value",
        4 => "exception 4: the device has failed",
        5 => "exception 5: the device needs longer",
        6 => "exception 6: the device is busy",
        7 => "exception 7: the device cannot do it",
        8 => "exception 8: the device's memory is damaged",
        0x0a => "exception 10: the gateway has no path to the device",
        0x0b => "exception 11: the device does not answer its gateway",
        _ => "an exception with a code of the maker's own",
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
    pub what: UnitRequest,
}

/// What is asked of a unit. Bits and registers are counted from 0, as the messages count them and not as many manuals do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum UnitRequest {
    /// Read so many of these bits or registers, from this one on: at most [`MAX_BITS`] or [`MAX_REGISTERS`].
    Read(Table, u16, u16),
    /// Switch this coil (function 5).
    Switch(u16, bool),
    /// Write this holding register (function 6).
    Set(u16, u16),
    /// Write three holding registers, from this one on (function 16).
    Write(u16, [u16; 3]),
}

/// What a device has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Table {
    /// Bits that may be written: digital outputs (function 1).
    Coils,
    /// Bits that may only be read: digital inputs (function 2).
    DiscreteInputs,
    /// Registers that may be written: analog outputs (function 3).
    HoldingRegisters,
    /// Registers that may only be read: analog inputs (function 4).
    InputRegisters,
}

impl Table {
    const fn has_bits(self) -> bool {
        matches!(self, Table::Coils | Table::DiscreteInputs)
    }
}

impl UnitRequest {
    const fn function(self) -> u8 {
        match self {
            UnitRequest::Read(Table::Coils, ..) => 0x01,
            UnitRequest::Read(Table::DiscreteInputs, ..) => 0x02,
            UnitRequest::Read(Table::HoldingRegisters, ..) => 0x03,
            UnitRequest::Read(Table::InputRegisters, ..) => 0x04,
            UnitRequest::Switch(..) => 0x05,
            UnitRequest::Set(..) => 0x06,
            UnitRequest::Write(..) => 0x10,
        }
    }

    /// What is asked about, and a second word: how many, or the value.
    const fn words(self) -> [u16; 2] {
        match self {
            UnitRequest::Read(_, first, count) => [first, count],
            UnitRequest::Switch(at, on) => [at, if on { 0xff00 } else { 0 }],
            UnitRequest::Set(at, value) => [at, value],
            UnitRequest::Write(first, words) => [first, words.len() as u16],
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

/// The bits or registers of an answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Answer {
    words: [u16; MAX_REGISTERS],
    len: usize,
}

impl Answer {
    /// The registers; none after a question that writes.
    #[must_use]
    pub fn registers(&self) -> &[u16] {
        &self.words[..self.len]
    }

    /// The bits, the first one in the lowest; 0 after a question that asks for none.
    #[must_use]
    pub const fn bits(&self) -> u32 {
        self.words[0] as u32 | (self.words[1] as u32) << 16
    }
}

/// What stands before the message in a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Header {
    pub transaction: u16,
    /// How many bytes the whole frame has.
    pub frame_len: usize,
}

impl Header {
    /// The header of the first frame of what came; `None` while more of it must come.
    ///
    /// # Errors
    /// It begins no frame: [`NoAnswer::Protocol`] or [`NoAnswer::Length`].
    pub fn of(came: &[u8]) -> Result<Option<Header>, NoAnswer> {
        let word = |at: usize| Some(u16::from_be_bytes([*came.get(at)?, *came.get(at + 1)?]));
        let (Some(transaction), Some(protocol), Some(length)) = (word(0), word(2), word(4)) else {
            return Ok(None);
        };
        if protocol != 0 {
            return Err(NoAnswer::Protocol);
        }
        // The unit, a function and a byte are the least.
        let frame_len = HEADER - 1 + usize::from(length);
        if length < 3 || frame_len > MAX_FRAME {
            return Err(NoAnswer::Length);
        }
        Ok(Some(Header { transaction, frame_len }))
    }
}

impl Question {
    /// The frame to send.
    #[must_use]
    pub fn bytes(&self) -> Bytes {
        let mut frame = Bytes { bytes: [0; 19], len: 0 };
        // Bytes that follow the length: the unit, and the message.
        let length: u16 = match self.what {
            UnitRequest::Write(_, words) => 7 + 2 * words.len() as u16,
            UnitRequest::Read(..) | UnitRequest::Switch(..) | UnitRequest::Set(..) => 6,
        };
        for word in [self.transaction, 0, length] {
            frame.push(&word.to_be_bytes());
        }
        frame.push(&[self.unit, self.what.function()]);
        self.what.words().iter().for_each(|word| frame.push(&word.to_be_bytes()));
        if let UnitRequest::Write(_, words) = self.what {
            frame.push(&[2 * words.len() as u8]);
            words.iter().for_each(|word| frame.push(&word.to_be_bytes()));
        }
        frame
    }

    /// Reads what came: bits or registers when the whole answer is there, and `None` while more must come.
    ///
    /// # Errors
    /// It is not the answer, or a refusal.
    pub fn answer(&self, came: &[u8]) -> Result<Option<Answer>, NoAnswer> {
        let Some(Header { transaction, frame_len: whole }) = Header::of(came)? else { return Ok(None) };
        if came.len() > whole {
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
        self.content(message).map(Some)
    }

    fn content(&self, message: &[u8]) -> Result<Answer, NoAnswer> {
        let mut answer = Answer { words: [0; MAX_REGISTERS], len: 0 };
        let UnitRequest::Read(table, _, count) = self.what else {
            // What was written comes back.
            let echo = self.what.words().map(u16::to_be_bytes);
            return match message.len() {
                4 if message == echo.as_flattened() => Ok(answer),
                4 => Err(NoAnswer::Question),
                _ => Err(NoAnswer::Length),
            };
        };
        let len = if table.has_bits() { usize::from(count.div_ceil(8)) } else { 2 * usize::from(count) };
        let most = if table.has_bits() { count <= MAX_BITS } else { usize::from(count) <= MAX_REGISTERS };
        let said = message
            .split_first()
            .filter(|(bytes, said)| usize::from(**bytes) == said.len() && said.len() == len && most);
        let (_, said) = said.ok_or(NoAnswer::Length)?;
        if table.has_bits() {
            let mut bytes = [0; 4];
            bytes[..len].copy_from_slice(said);
            // Bits beyond those that were asked for are padding.
            let bits = u32::from_le_bytes(bytes) & (u64::MAX << count ^ u64::MAX) as u32;
            (answer.words[0], answer.words[1]) = (bits as u16, (bits >> 16) as u16);
            return Ok(answer);
        }
        for (to, word) in answer.words.iter_mut().zip(said.chunks_exact(2)) {
            *to = u16::from_be_bytes([word[0], word[1]]);
        }
        answer.len = usize::from(count);
        Ok(answer)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const READ: Question =
        Question { transaction: 0xd605, unit: 2, what: UnitRequest::Read(Table::InputRegisters, 0, 3) };
    const WRITE: Question =
        Question { transaction: 0x34ab, unit: 2, what: UnitRequest::Write(0, [0x0900, 0x00ff, 0xffff]) };
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
        assert_eq!(written.map(|answer| answer.map(|answer| answer.registers().len())), Ok(Some(0)));
        let read = READ.answer(&READING).expect("an answer").expect("whole");
        assert_eq!(read.registers(), [0xf900, 0, 0x0d00]);
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
        assert_eq!(
            NoAnswer::Exception(2).to_string(),
            "exception 2: the device has no such bits or registers"
        );
        assert!(!NoAnswer::Exception(2).passes() && NoAnswer::Exception(11).passes());
        // Other registers than were written.
        assert_eq!(WRITE.answer(&[0x34, 0xab, 0, 0, 0, 6, 2, 16, 0, 1, 0, 3]), Err(NoAnswer::Question));
    }

    /// The examples of the specification (Modbus Application Protocol 1.1b3, 6.1, 6.2, 6.3, 6.5 and 6.6), in a frame of TCP.
    #[test]
    fn bits_and_single_values_are_those_of_the_specification() {
        let question = |what| Question { transaction: 1, unit: 1, what };
        let framed = |message: &[u8]| [&[0, 1, 0, 0, 0, message.len() as u8 + 1, 1], message].concat();
        let coils = question(UnitRequest::Read(Table::Coils, 0x13, 0x13));
        assert_eq!(coils.bytes().as_slice(), framed(&[1, 0, 0x13, 0, 0x13]));
        let read =
            coils.answer(&framed(&[1, 3, 0xcd, 0x6b, 5])).map(|answer| answer.map(|answer| answer.bits()));
        assert_eq!(read, Ok(Some(0x05_6bcd)));
        let inputs = question(UnitRequest::Read(Table::DiscreteInputs, 0xc4, 0x16));
        assert_eq!(inputs.bytes().as_slice(), framed(&[2, 0, 0xc4, 0, 0x16]));
        // What pads the last byte counts for nothing.
        for last in [0x35, 0xf5] {
            let read = inputs.answer(&framed(&[2, 3, 0xac, 0xdb, last]));
            assert_eq!(read.map(|answer| answer.map(|answer| answer.bits())), Ok(Some(0x35_dbac)));
        }
        let holding = question(UnitRequest::Read(Table::HoldingRegisters, 0x6b, 3));
        assert_eq!(holding.bytes().as_slice(), framed(&[3, 0, 0x6b, 0, 3]));
        let read =
            holding.answer(&framed(&[3, 6, 2, 0x2b, 0, 0, 0, 0x64])).expect("an answer").expect("whole");
        assert_eq!(read.registers(), [555, 0, 100]);
        // What is written comes back.
        for (what, message) in [
            (UnitRequest::Switch(0xac, true), [5, 0, 0xac, 0xff, 0]),
            (UnitRequest::Switch(0xac, false), [5, 0, 0xac, 0, 0]),
            (UnitRequest::Set(1, 3), [6, 0, 1, 0, 3]),
        ] {
            let asked = question(what);
            assert_eq!(asked.bytes().as_slice(), framed(&message));
            assert!(matches!(asked.answer(&framed(&message)), Ok(Some(_))));
            let mut other = message;
            other[2] ^= 1;
            assert_eq!(asked.answer(&framed(&other)), Err(NoAnswer::Question));
        }
        // More than was asked for.
        assert_eq!(coils.answer(&framed(&[1, 4, 0xcd, 0x6b, 5, 0])), Err(NoAnswer::Length));
        assert_eq!(
            question(UnitRequest::Read(Table::Coils, 0, 33)).answer(&framed(&[1, 5, 0, 0, 0, 0, 0])),
            Err(NoAnswer::Length)
        );
    }
}
