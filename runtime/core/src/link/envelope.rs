//! A message between processes: plain words, whatever they hold, so that a foreign or damaged one is an error and never
//! undefined behaviour. A sum over all words tells of damage: a damaged message is a lost one.

use crate::link::message::{Header, Kind, Message, OrderKind, RequestKind};
use crate::model::wire::{BadWords, WORDS};
use crate::safety::braking::BrakingLaw;
use crate::safety::rate::{FullRate, RateMargin};

/// Version of the layout of an [`Envelope`] and of what its words mean. Raise it with every change of either.
pub const LAYOUT: u64 = 8;

/// Words of a message's head.
const HEAD: usize = 17;

/// Words of a message, head and body.
pub const ENVELOPE_WORDS: usize = HEAD + WORDS;

/// Which of them is the length of the body.
const LEN_WORD: usize = 4;

/// The kinds of messages; one travels as its place in this list.
const KINDS: [Kind; 17] = [
    Kind::Order(OrderKind::Query),
    Kind::Order(OrderKind::Start),
    Kind::Order(OrderKind::Step),
    Kind::Order(OrderKind::End),
    Kind::Order(OrderKind::Abort),
    Kind::Order(OrderKind::Brake),
    Kind::Order(OrderKind::Stop),
    Kind::Order(OrderKind::Reset),
    Kind::Request(RequestKind::Query),
    Kind::Request(RequestKind::Demand),
    Kind::Request(RequestKind::Brake),
    Kind::Request(RequestKind::Stop),
    Kind::Request(RequestKind::Reset),
    Kind::Read,
    Kind::Reply,
    Kind::Fault,
    Kind::Command,
];

/// What every message of a cell's run carries: messages of another run, or of an earlier attempt to start it, are none.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Seal {
    /// Number of the session, drawn at random by its launcher.
    pub session: u64,
    /// The launcher's attempts to start it, counted from 1.
    pub epoch: u64,
}

/// A message between processes, as it lies in shared memory.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Envelope {
    layout: u64,
    session: u64,
    epoch: u64,
    /// Ordinal of the request that it is or answers, counted from 1; of a board's message, how many were shown before.
    pub sequence: u64,
    /// How often a request has been sent, this time included; 1 for a message that is not a request.
    pub attempt: u64,
    /// The sum over all other words that count.
    check: u64,
    head: [u64; HEAD],
    body: [u64; WORDS],
}

impl Envelope {
    /// No message.
    pub const EMPTY: Envelope = Envelope {
        layout: 0,
        session: 0,
        epoch: 0,
        sequence: 0,
        attempt: 0,
        check: 0,
        head: [0; HEAD],
        body: [0; WORDS],
    };

    /// Puts a message under a seal.
    pub fn seal(message: &Message, seal: Seal, sequence: u64) -> Envelope {
        let Header { kind, flags, epoch, step, instruction, len, payload, dt, duration, rate_margin, law } =
            message.header;
        let kind = KINDS.iter().position(|&known| known == kind).map_or(u64::MAX, |place| place as u64);
        let RateMargin { rise, fall, bend, full, most } = rate_margin;
        let head = [
            kind,
            u64::from(flags),
            step,
            u64::from(instruction),
            u64::from(len),
            payload,
            dt.to_bits(),
            duration.to_bits(),
            rise.to_bits(),
            fall.to_bits(),
            bend.to_bits(),
            full.rise.to_bits(),
            full.bend.to_bits(),
            u64::from(epoch),
            law.fall.to_bits(),
            law.bend.to_bits(),
            most.to_bits(),
        ];
        let mut envelope = Envelope {
            layout: LAYOUT,
            session: seal.session,
            epoch: seal.epoch,
            sequence,
            attempt: 1,
            check: 0,
            head,
            body: [0; WORDS],
        };
        let words = message.words();
        envelope.body[..words.len()].copy_from_slice(words);
        envelope.check = envelope.sum(words.len());
        envelope
    }

    /// A sum over the words that count. Each of its steps is a bijection of the sum so far. So a change of one word always
    /// changes the sum; a change of several words leaves it as it was with a probability of 2⁻⁶⁴.
    fn sum(&self, len: usize) -> u64 {
        let fixed = [self.layout, self.session, self.epoch, self.sequence, self.attempt];
        let body = self.body.get(..len).unwrap_or(&self.body);
        let words = fixed.iter().chain(&self.head).chain(body);
        words.fold(0, |sum: u64, word| (sum ^ word).wrapping_mul(0x9e37_79b9_7f4a_7c15).rotate_left(29))
    }

    /// Whether it is of this run and layout.
    pub fn is_under(&self, seal: Seal) -> bool {
        (self.layout, self.session, self.epoch) == (LAYOUT, seal.session, seal.epoch)
    }

    /// The same request, sent so often.
    pub fn in_attempt(mut self, attempt: u64) -> Envelope {
        self.attempt = attempt;
        self.check = self.sum((self.head[LEN_WORD] as usize).min(WORDS));
        self
    }

    /// Whether nothing in it is damaged.
    pub fn is_whole(&self) -> bool {
        let len = usize::try_from(self.head[LEN_WORD]).unwrap_or(usize::MAX);
        len <= WORDS && self.check == self.sum(len)
    }

    /// The message in it.
    ///
    /// # Errors
    /// [`BadWords`] when it is damaged, or its first words are no header of a process in its senses; `message` is then as it
    /// was.
    pub fn open(&self, message: &mut Message) -> Result<(), BadWords> {
        let [
            kind,
            flags,
            step,
            instruction,
            len,
            payload,
            dt,
            duration,
            rise,
            fall,
            bend,
            full_rise,
            full_bend,
            epoch,
            law_fall,
            law_bend,
            most,
        ] = self.head;
        let narrow = |word: u64| u32::try_from(word).map_err(|_| BadWords);
        let kind = usize::try_from(kind).ok().and_then(|place| KINDS.get(place));
        let len = narrow(len)?;
        if !self.is_whole() {
            return Err(BadWords);
        }
        let header = Header {
            kind: *kind.ok_or(BadWords)?,
            flags: narrow(flags)?,
            epoch: narrow(epoch)?,
            step,
            instruction: narrow(instruction)?,
            len,
            payload,
            dt: f64::from_bits(dt),
            duration: f64::from_bits(duration),
            rate_margin: RateMargin {
                rise: f64::from_bits(rise),
                fall: f64::from_bits(fall),
                bend: f64::from_bits(bend),
                full: FullRate { rise: f64::from_bits(full_rise), bend: f64::from_bits(full_bend) },
                most: f64::from_bits(most),
            },
            law: BrakingLaw { fall: f64::from_bits(law_fall), bend: f64::from_bits(law_bend) },
        };
        if !header.is_sound() {
            return Err(BadWords);
        }
        message.header = header;
        message.body[..len as usize].copy_from_slice(&self.body[..len as usize]);
        Ok(())
    }

    /// The same under another seal, if it is whole and under this one.
    #[must_use]
    pub fn moved(mut self, from: Seal, to: Seal) -> Option<Envelope> {
        if !(self.is_under(from) && self.is_whole()) {
            return None;
        }
        (self.session, self.epoch) = (to.session, to.epoch);
        self.check = self.sum((self.head[LEN_WORD] as usize).min(WORDS));
        Some(self)
    }

    /// Adds it to what is sent over a network: its words that count, each with its lowest byte first.
    pub fn put_bytes(&self, bytes: &mut Vec<u8>) {
        let fixed = [self.layout, self.session, self.epoch, self.sequence, self.attempt, self.check];
        let (head, body) = self.words();
        bytes.extend(fixed.iter().chain(head).chain(body).flat_map(|word| word.to_le_bytes()));
    }

    /// Reads what [`put_bytes`](Envelope::put_bytes) has written. Whether it is whole, it says itself.
    ///
    /// # Errors
    /// [`BadWords`] where there are too few or too many bytes.
    pub fn from_bytes(bytes: &[u8]) -> Result<Envelope, BadWords> {
        let (words, rest) = bytes.as_chunks::<8>();
        if !rest.is_empty() || words.len() > 6 + HEAD + WORDS {
            return Err(BadWords);
        }
        let mut words = words.iter().map(|word| u64::from_le_bytes(*word));
        let mut next = || words.next().ok_or(BadWords);
        let [layout, session, epoch, sequence, attempt, check] =
            [next()?, next()?, next()?, next()?, next()?, next()?];
        let mut envelope = Envelope { layout, session, epoch, sequence, attempt, check, ..Envelope::EMPTY };
        for word in &mut envelope.head {
            *word = next()?;
        }
        let len =
            usize::try_from(envelope.head[LEN_WORD]).ok().filter(|&len| len <= WORDS).ok_or(BadWords)?;
        for word in &mut envelope.body[..len] {
            *word = next()?;
        }
        if next().is_ok() { Err(BadWords) } else { Ok(envelope) }
    }

    /// These words under a seal of their own, head first: whole, whatever they say.
    pub fn of_words(words: &[u64]) -> Envelope {
        let mut words = words.iter().copied();
        let mut next = || words.next().unwrap_or(0);
        let (head, body) = (core::array::from_fn(|_| next()), core::array::from_fn(|_| next()));
        let mut envelope =
            Envelope { layout: LAYOUT, session: 0, epoch: 0, sequence: 1, attempt: 1, check: 0, head, body };
        envelope.check = envelope.sum((head[LEN_WORD] as usize).min(WORDS));
        envelope
    }

    /// The words of its head and of its body that count.
    pub fn words(&self) -> (&[u64], &[u64]) {
        (&self.head, &self.body[..(self.head[LEN_WORD] as usize).min(WORDS)])
    }

    /// The same with bits of one of its words turned round, counted from the seal's.
    pub fn damaged(mut self, word: u64, bits: u64) -> Envelope {
        let counts = HEAD + (self.head[LEN_WORD] as usize).min(WORDS);
        match word as usize % (6 + counts) {
            0 => self.layout ^= bits,
            1 => self.session ^= bits,
            2 => self.epoch ^= bits,
            3 => self.sequence ^= bits,
            4 => self.check ^= bits,
            5 => self.attempt ^= bits,
            word if word < 6 + HEAD => self.head[word - 6] ^= bits,
            word => self.body[word - 6 - HEAD] ^= bits,
        }
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SEAL: Seal = Seal { session: 0x1234_5678_9abc_def0, epoch: 2 };

    fn message(kind: Kind) -> Message {
        let mut message = Message::new(kind);
        let full = FullRate { rise: 0.25, bend: 1e-300 };
        let rate_margin = RateMargin { rise: 1.5, fall: -0.0, bend: f64::INFINITY, full, most: 0.5 };
        message.header = Header {
            kind,
            flags: 0x8000_0001,
            epoch: 0x8000_0002,
            step: u64::MAX,
            instruction: 7,
            len: 3,
            payload: 0xfeed,
            dt: 0.5e-3,
            duration: 1e-3,
            rate_margin,
            law: BrakingLaw { fall: 2.5, bend: 1e9 },
        };
        // The bits of a NaN: a payload may have any.
        message.body[..3].copy_from_slice(&[1, 0x7ff8_0000_0000_0001, u64::MAX]);
        message
    }

    #[test]
    fn a_message_of_every_kind_comes_out_as_it_went_in() {
        for kind in KINDS {
            let sent = message(kind);
            let envelope = Envelope::seal(&sent, SEAL, 5);
            assert!(envelope.is_under(SEAL) && envelope.sequence == 5);
            let mut came = Message::empty();
            assert_eq!(envelope.open(&mut came), Ok(()));
            // Bits, not values: a zero keeps its sign.
            assert_eq!(format!("{:?}", came.header), format!("{:?}", sent.header));
            assert_eq!(came.words(), sent.words());
        }
    }

    #[test]
    fn what_is_of_another_session_attempt_or_layout_is_not_under_the_seal() {
        let envelope = Envelope::seal(&message(Kind::Read), SEAL, 1);
        assert!(!envelope.is_under(Seal { session: 1, ..SEAL }));
        assert!(!envelope.is_under(Seal { epoch: 1, ..SEAL }));
        assert!(!Envelope { layout: LAYOUT + 1, ..envelope }.is_under(SEAL));
        assert!(!Envelope::EMPTY.is_under(SEAL));
    }

    #[test]
    fn what_crosses_a_network_comes_out_as_it_went_in_and_no_other_length_is_a_message() {
        let sent = Envelope::seal(&message(Kind::Reply), SEAL, 9).in_attempt(3);
        let mut bytes = Vec::new();
        sent.put_bytes(&mut bytes);
        let came = Envelope::from_bytes(&bytes).expect("whole");
        assert_eq!(format!("{came:?}"), format!("{sent:?}"));
        for len in 0..bytes.len() {
            assert!(Envelope::from_bytes(&bytes[..len]).is_err(), "{len} bytes");
        }
        bytes.extend([0; 8]);
        assert!(Envelope::from_bytes(&bytes).is_err());
    }

    #[test]
    fn a_message_is_moved_from_its_own_seal_only_and_keeps_its_number_and_attempt() {
        let (here, there) = (SEAL, Seal { session: 77, epoch: 1 });
        let sent = Envelope::seal(&message(Kind::Read), here, 9).in_attempt(3);
        assert!(sent.moved(there, here).is_none());
        assert!(sent.damaged(9, 1).moved(here, there).is_none());
        let moved = sent.moved(here, there).expect("its own");
        assert!(moved.is_under(there) && moved.is_whole() && (moved.sequence, moved.attempt) == (9, 3));
    }

    #[test]
    fn fault_16_a_message_of_which_any_bit_is_the_wrong_way_round_is_none() {
        let sent = message(Kind::Reply);
        let len = sent.words().len();
        for word in 0..HEAD + len {
            for bit in 0..64 {
                let mut envelope = Envelope::seal(&sent, SEAL, 1);
                match word.checked_sub(HEAD) {
                    None => envelope.head[word] ^= 1 << bit,
                    Some(word) => envelope.body[word] ^= 1 << bit,
                }
                let opened = envelope.open(&mut Message::empty());
                assert_eq!(opened, Err(BadWords), "word {word}, bit {bit}");
            }
        }
    }

    #[test]
    fn fault_16_times_and_limits_that_no_process_in_its_senses_sends_are_no_message() {
        let opens = |change: &dyn Fn(&mut Header)| {
            let mut sent = message(Kind::Reply);
            change(&mut sent.header);
            Envelope::seal(&sent, SEAL, 1).open(&mut Message::empty())
        };
        assert_eq!(opens(&|header| header.dt = header.duration), Ok(()));
        let dt = |dt: f64| opens(&move |header| header.dt = dt);
        let duration = |duration: f64| opens(&move |header| header.duration = duration);
        for bad in [-1e-9, 1.001e-3, f64::INFINITY, f64::NAN] {
            assert_eq!(dt(bad), Err(BadWords), "{bad} s of path time in 1 ms");
        }
        for bad in [-1e-3, 0.4e-3, f64::INFINITY, f64::NAN] {
            assert_eq!(duration(bad), Err(BadWords), "a step of {bad} s");
        }
        for bad in [-1.0, f64::NEG_INFINITY, f64::NAN] {
            assert_eq!(opens(&|header| header.rate_margin.rise = bad), Err(BadWords), "a rise of {bad}");
            assert_eq!(opens(&|header| header.rate_margin.full.bend = bad), Err(BadWords), "a bend of {bad}");
            assert_eq!(opens(&|header| header.law.fall = bad), Err(BadWords), "a fall of {bad}");
        }
    }

    #[test]
    fn a_damaged_head_is_no_message() {
        // Kind, flags, instruction, length, epoch: the words that not every number spells.
        for (word, value) in
            [(0, 17), (0, u64::MAX), (1, 1 << 32), (3, 1 << 32), (4, 57), (4, u64::MAX), (13, 1 << 32)]
        {
            let mut envelope = Envelope::seal(&message(Kind::Reply), SEAL, 1);
            envelope.head[word] = value;
            envelope.check = envelope.sum(message(Kind::Reply).words().len());
            assert_eq!(envelope.open(&mut Message::empty()), Err(BadWords), "word {word}: {value}");
        }
    }
}
