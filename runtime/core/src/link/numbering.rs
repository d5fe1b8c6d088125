//! Which answer is whose, where messages may be lost, damaged, doubled or late.
//!
//! In: requests and answers of one port, in envelopes. Out: each request to its server once, each answer to its client once.
//! A request that is not answered is sent again under the same number; what has been done already is not done again, but
//! answered again.

use core::cell::{Cell, RefCell};

use super::envelope::{Envelope, Seal};
use crate::link::message::Message;

/// The asking end.
#[derive(Debug)]
pub struct Asking {
    seal: Seal,
    /// Ordinal of the last request, counted from 1, and how often it was sent.
    sequence: Cell<u64>,
    attempt: Cell<u64>,
    /// Whether it has no answer yet.
    waits: Cell<bool>,
    request: RefCell<Message>,
}

impl Asking {
    /// Nothing has been asked yet, in the run of this seal.
    pub const fn new(seal: Seal) -> Asking {
        Asking {
            seal,
            sequence: Cell::new(0),
            attempt: Cell::new(0),
            waits: Cell::new(false),
            request: RefCell::new(Message::empty()),
        }
    }

    /// A new request. The answer to the one before has another ordinal.
    pub fn ask(&self, request: &Message) -> Envelope {
        self.sequence.set(self.sequence.get() + 1);
        self.attempt.set(1);
        self.waits.set(true);
        self.request.borrow_mut().copy_from(request);
        Envelope::seal(request, self.seal, self.sequence.get())
    }

    /// The last request once more, if it has no answer.
    pub fn ask_again(&self) -> Option<Envelope> {
        self.waits.get().then(|| {
            self.attempt.set(self.attempt.get() + 1);
            let envelope = Envelope::seal(&self.request.borrow(), self.seal, self.sequence.get());
            envelope.in_attempt(self.attempt.get())
        })
    }

    /// Takes the answer to the last request: an envelope that is whole and bears its ordinal.
    pub fn hears(&self, shown: &Envelope, reply: &mut Message) -> bool {
        let is_due = self.waits.get() && shown.is_under(self.seal) && shown.sequence == self.sequence.get();
        let came = is_due && shown.open(reply).is_ok();
        if came {
            self.waits.set(false);
        }
        came
    }
}

/// What a server does with an envelope.
#[derive(Debug)]
#[expect(clippy::large_enum_variant, reason = "it is looked at where it was made")]
pub enum Disposition {
    /// It is a new request.
    New,
    /// It asks again for an answer that was given: this one.
    Again(Envelope),
    /// It is not a request of this run, or one that was received already.
    Nothing,
}

/// The answering end.
#[derive(Debug)]
pub struct Answering {
    seal: Seal,
    /// Ordinal of the request taken last, counted from 1, and in which attempt it was heard last.
    sequence: Cell<u64>,
    attempt: Cell<u64>,
    /// Its answer, once there is one.
    answer: RefCell<Message>,
    answered: Cell<bool>,
}

impl Answering {
    /// Nothing has been answered yet, in the run of this seal.
    pub const fn new(seal: Seal) -> Answering {
        Answering {
            seal,
            sequence: Cell::new(0),
            attempt: Cell::new(0),
            answer: RefCell::new(Message::empty()),
            answered: Cell::new(false),
        }
    }

    /// Takes a new request.
    pub fn hears(&self, shown: &Envelope, request: &mut Message) -> Disposition {
        let taken = self.sequence.get();
        let is_new = shown.sequence > taken;
        let is_again = shown.sequence == taken && shown.attempt > self.attempt.get();
        let is_due = shown.is_under(self.seal) && (is_new || is_again);
        let mut is_whole = || if is_new { shown.open(request).is_ok() } else { shown.is_whole() };
        if !(is_due && is_whole()) {
            return Disposition::Nothing;
        }
        self.attempt.set(shown.attempt);
        if is_new {
            self.sequence.set(shown.sequence);
            self.answered.set(false);
            return Disposition::New;
        }
        if self.answered.get() {
            return Disposition::Again(Envelope::seal(&self.answer.borrow(), self.seal, taken));
        }
        // Its answer is still to come, and will be heard.
        Disposition::Nothing
    }

    /// The answer to the request taken last.
    pub fn answer(&self, reply: &Message) -> Envelope {
        self.answer.borrow_mut().copy_from(reply);
        self.answered.set(true);
        Envelope::seal(reply, self.seal, self.sequence.get())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::link::message::Kind;

    const SEAL: Seal = Seal { session: 3, epoch: 1 };

    fn numbered(step: u64) -> Message {
        let mut message = Message::new(Kind::Reply);
        message.header.step = step;
        message
    }

    #[test]
    fn a_request_is_done_once_and_answered_as_often_as_it_is_asked() {
        let (asking, answering) = (Asking::new(SEAL), Answering::new(SEAL));
        let (mut request, mut reply) = (Message::empty(), Message::empty());
        for step in 1..4 {
            let first = asking.ask(&numbered(step));
            let second = asking.ask_again().expect("no answer yet");
            // The first one is late, and comes twice after the second one.
            assert!(matches!(answering.hears(&second, &mut request), Disposition::New));
            assert_eq!(request.header.step, step);
            for old in [first, first, second] {
                assert!(matches!(answering.hears(&old, &mut request), Disposition::Nothing));
            }
            // Asked again while it is at work: the answer is to come.
            let third = asking.ask_again().expect("no answer yet");
            assert!(matches!(answering.hears(&third, &mut request), Disposition::Nothing));
            let answer = answering.answer(&numbered(10 * step));
            // That one is lost. The next attempt is answered alike, and the answer taken once.
            let fourth = asking.ask_again().expect("no answer yet");
            let Disposition::Again(again) = answering.hears(&fourth, &mut request) else { panic!("{step}") };
            assert!(asking.hears(&again, &mut reply) && reply.header.step == 10 * step);
            assert!(!asking.hears(&answer, &mut reply) && asking.ask_again().is_none());
        }
    }

    #[test]
    fn what_is_damaged_of_another_run_or_of_an_earlier_request_is_neither_request_nor_answer() {
        let (asking, answering) = (Asking::new(SEAL), Answering::new(SEAL));
        let (mut request, mut reply) = (Message::empty(), Message::empty());
        let old = asking.ask(&numbered(1));
        assert!(matches!(answering.hears(&old, &mut request), Disposition::New));
        let early = answering.answer(&numbered(1));
        let asked = asking.ask(&numbered(2));
        assert!(!asking.hears(&early, &mut reply), "the answer to the request before");
        // The words of the envelope, its ordinal and its attempt among them.
        for word in 0..20 {
            let damaged = asked.damaged(word, 1 << 3);
            assert!(matches!(answering.hears(&damaged, &mut request), Disposition::Nothing), "word {word}");
        }
        let foreign = Envelope::seal(&numbered(2), Seal { epoch: 2, ..SEAL }, 2);
        assert!(matches!(answering.hears(&foreign, &mut request), Disposition::Nothing));
        assert!(matches!(answering.hears(&asked, &mut request), Disposition::New));
        let answer = answering.answer(&numbered(20));
        for word in 0..20 {
            assert!(!asking.hears(&answer.damaged(word, 1 << 3), &mut reply), "word {word}");
            let again = asking.ask_again().expect("no answer yet").damaged(word, 1 << 3);
            assert!(matches!(answering.hears(&again, &mut request), Disposition::Nothing), "word {word}");
        }
        assert!(asking.hears(&answer, &mut reply) && reply.header.step == 20);
    }
}
