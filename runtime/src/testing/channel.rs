//! A channel of which the link loses, doubles, delays or alters messages: decorators on the ends of ports and boards,
//! as smoltcp's fault injector is one on its devices.
//!
//! In: what the sender sent, in the envelopes that go through shared memory: numbered, under the session's seal, with a
//! checksum. Out: what of it the receiver's end lets in.

use core::cell::{Cell, RefCell};
use std::collections::VecDeque;
use std::rc::Rc;

use super::case::{Channel, LinkFault};
use super::random::Random;
use super::stage::Stage;
use crate::link::envelope::{Envelope, Seal};
use crate::link::{Board, Client, Nanos, Server};
use crate::message::Message;
use crate::wire::WORDS;

/// Messages that a channel remembers, to send an old one again.
const REMEMBERED: usize = 64;

const SEAL: Seal = Seal { session: 0x6d72_726f_6320_7465, epoch: 2 };
const EARLIER: Seal = Seal { epoch: 1, ..SEAL };

/// One direction of a port, or a board.
pub(super) struct Direction {
    stage: Rc<Stage>,
    channel: Channel,
    to: usize,
    /// Envelopes on their way, and when each is there \[ns\].
    flight: RefCell<Vec<(Nanos, Envelope)>>,
    past: RefCell<VecDeque<Message>>,
}

impl Direction {
    pub fn new(stage: &Rc<Stage>, channel: Channel, to: usize) -> Direction {
        stage.channels.borrow_mut().push(channel);
        let (flight, past) = Default::default();
        Direction { stage: Rc::clone(stage), channel, to, flight, past }
    }

    /// Sends a message under a number.
    fn send(&self, message: &Message, sequence: u64) {
        let now = self.stage.now.get();
        let envelope = Envelope::seal(message, SEAL, sequence);
        let fault = self.stage.fault_of(self.channel);
        let Some(fault) = fault.filter(|_| self.is_struck(message)) else {
            self.remember(message);
            return self.put(now, envelope);
        };
        let step = self.stage.step;
        let mut random = self.stage.random.borrow_mut();
        match fault {
            LinkFault::Drop => {}
            LinkFault::Duplicate => {
                self.put(now, envelope);
                self.put(now, envelope);
            }
            LinkFault::Reorder => self.put(now + step, envelope),
            LinkFault::Delay(steps) => self.put(now + u64::from(steps) * step, envelope),
            LinkFault::Corrupt => {
                let damaged = (0..=random.below(3))
                    .fold(envelope, |damaged, _| damaged.damaged(random.next(), 1 << random.below(64)));
                self.put(now, damaged);
            }
            LinkFault::Replay => {
                self.put(now, envelope);
                if let Some(old) = self.past.borrow_mut().pop_front() {
                    let (seal, back) = if random.below(2) == 0 { (SEAL, 1) } else { (EARLIER, 0) };
                    self.put(now, Envelope::seal(&old, seal, sequence.saturating_sub(back)));
                }
            }
            LinkFault::Forge => {
                let mut forged = *message;
                forge(&mut forged, &mut random);
                self.put(now, Envelope::seal(&forged, SEAL, sequence));
            }
        }
    }

    fn put(&self, at: Nanos, envelope: Envelope) {
        self.flight.borrow_mut().push((at, envelope));
        self.stage.wake_at(self.to, at);
    }

    /// Takes what has come and is let in, the newest of it.
    fn take(&self, message: &mut Message, lets_in: impl Fn(u64) -> bool) -> bool {
        let now = self.stage.now.get();
        let mut taken = false;
        self.flight.borrow_mut().retain(|(at, envelope)| {
            if *at > now {
                self.stage.wake_at(self.to, *at);
                return true;
            }
            let whole = envelope.is_under(SEAL) && lets_in(envelope.sequence);
            taken |= whole && envelope.open(message).is_ok();
            false
        });
        taken
    }

    fn is_struck(&self, message: &Message) -> bool {
        let struck = self.stage.case.get().is_some_and(|case| case.is_at_work(message.header.step));
        self.stage.hits.set(self.stage.hits.get() + u64::from(struck));
        struck
    }

    fn remember(&self, message: &Message) {
        if self.stage.remembers(self.channel) {
            let mut past = self.past.borrow_mut();
            past.push_back(*message);
            if past.len() > REMEMBERED {
                past.pop_front();
            }
        }
    }
}

/// Turns one to three bits round, of the head or of the words that count.
fn forge(message: &mut Message, random: &mut Random) {
    for _ in 0..=random.below(3) {
        let bit = random.below(64);
        let flip = |x: f64| f64::from_bits(x.to_bits() ^ 1 << bit);
        let header = &mut message.header;
        let body = u64::from(header.len).clamp(1, WORDS as u64);
        match random.below(7 + body) {
            0 => header.flags ^= 1 << (bit % 9),
            1 => header.step ^= 1 << bit,
            2 => header.instruction ^= 1 << (bit % 32),
            // A length beyond the body is no envelope's.
            3 => header.len = (header.len ^ 1 << (bit % 6)).min(WORDS as u32),
            4 => header.payload ^= 1 << bit,
            5 => header.dt = flip(header.dt),
            6 => header.duration = flip(header.duration),
            word => message.body[(word - 7) as usize] ^= 1 << bit,
        }
    }
}

/// The asking end of a port. What is `inner`'s only wakes the other end.
pub(super) struct FaultyClient {
    pub inner: Box<dyn Client>,
    pub requests: Rc<Direction>,
    pub replies: Rc<Direction>,
    /// The number of the last request, and whether it is answered.
    pub sent: Cell<(u64, bool)>,
}

impl Client for FaultyClient {
    fn send(&self, request: &Message) {
        if self.requests.stage.speaks(self.requests.channel.from) {
            let number = self.sent.get().0 + 1;
            self.sent.set((number, false));
            self.requests.send(request, number);
            self.inner.send(request);
        }
    }

    fn receive(&self, reply: &mut Message) -> bool {
        self.inner.receive(&mut Message::empty());
        let (number, answered) = self.sent.get();
        let came = self.replies.take(reply, |sequence| sequence == number && !answered);
        self.sent.set((number, answered || came));
        came
    }
}

/// The answering end of a port.
pub(super) struct FaultyServer {
    pub inner: Box<dyn Server>,
    pub requests: Rc<Direction>,
    pub replies: Rc<Direction>,
    /// The number of the request taken last.
    pub taken: Cell<u64>,
}

impl Server for FaultyServer {
    fn receive(&self, request: &mut Message) -> bool {
        self.inner.receive(&mut Message::empty());
        self.requests.take(request, |sequence| {
            let is_new = sequence > self.taken.get();
            self.taken.set(sequence.max(self.taken.get()));
            is_new
        })
    }

    fn reply(&self, reply: &Message) {
        if self.replies.stage.speaks(self.replies.channel.from) {
            self.replies.send(reply, self.taken.get());
            self.inner.reply(reply);
        }
    }
}

/// A board: it shows what came last.
pub(super) struct FaultyBoard {
    pub channel: Direction,
    pub shown: RefCell<Option<Message>>,
    pub sent: Cell<u64>,
}

impl Board for FaultyBoard {
    fn write(&self, message: &Message) {
        if self.channel.stage.speaks(self.channel.channel.from) {
            self.sent.set(self.sent.get() + 1);
            self.channel.send(message, self.sent.get());
        }
    }

    fn read(&self, message: &mut Message) -> bool {
        let mut came = Message::empty();
        if self.channel.take(&mut came, |_| true) {
            *self.shown.borrow_mut() = Some(came);
        }
        let shown = self.shown.borrow();
        shown.as_ref().is_some_and(|shown| {
            message.copy_from(shown);
            true
        })
    }
}
