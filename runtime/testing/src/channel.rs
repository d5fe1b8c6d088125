//! A channel on which messages are lost, doubled, delayed or altered: decorators on the ends of ports and boards, like
//! smoltcp's fault injector, which is a decorator on its devices.
//!
//! In: what the sender sent, in the envelopes that go through shared memory: numbered, under the session's seal, with a
//! checksum. Out: the messages among them that the receiver's end accepts.

use core::cell::{Cell, RefCell};
use std::collections::VecDeque;
use std::rc::Rc;

use super::case::{Channel, LinkFault};
use super::random::Random;
use super::stage::Stage;
use mrroc_core::link::envelope::{Envelope, Seal};
use mrroc_core::link::message::Message;
use mrroc_core::link::numbering::{self, Disposition};
use mrroc_core::link::{Board, Client, Nanos, Server};
use mrroc_core::payload::WORDS;

/// Number of messages that a channel remembers, so that it can send an old one again.
const REMEMBERED: usize = 64;

const SEAL: Seal = Seal { session: 0x6d72_726f_6320_7465, epoch: 2 };
const EARLIER: Seal = Seal { epoch: 1, ..SEAL };

/// One direction of a port, or a board.
pub(super) struct Direction {
    stage: Rc<Stage>,
    channel: Channel,
    to: usize,
    /// Envelopes under way, and when each arrives \[ns\].
    flight: RefCell<Vec<(Nanos, Envelope)>>,
    past: RefCell<VecDeque<Envelope>>,
}

impl Direction {
    pub fn new(stage: &Rc<Stage>, channel: Channel, to: usize) -> Direction {
        stage.channels.borrow_mut().push(channel);
        let (flight, past) = Default::default();
        Direction { stage: Rc::clone(stage), channel, to, flight, past }
    }

    fn send(&self, envelope: Envelope) {
        let now = self.stage.now.get();
        let fault = self.stage.fault_of(self.channel);
        let Some(fault) = fault.filter(|_| self.is_struck()) else {
            self.remember(envelope);
            return self.put(now, envelope);
        };
        let (step, sequence) = (self.stage.step, envelope.sequence);
        let mut random = self.stage.random.borrow_mut();
        match fault {
            LinkFault::Drop => {}
            LinkFault::Duplicate => {
                self.put(now, envelope);
                self.put(now, envelope);
            }
            LinkFault::Reorder => self.put(now + step, envelope),
            LinkFault::Delay(steps) => self.put(now + u64::from(steps) * step, envelope),
            LinkFault::Wire(wire) => {
                self.remember(envelope);
                if random.below(1000) >= u64::from(wire.lost_per_mille) {
                    let [least, most] = wire.takes_us.map(|us| u64::from(us) * 1000);
                    self.put(now + least + random.below(most.saturating_sub(least) + 1), envelope);
                }
            }
            LinkFault::Corrupt => {
                let damaged = (0..=random.below(3))
                    .fold(envelope, |damaged, _| damaged.damaged(random.next(), 1 << random.below(64)));
                self.put(now, damaged);
            }
            LinkFault::Replay => {
                self.put(now, envelope);
                if let Some(old) = self.past.borrow_mut().pop_front() {
                    let (seal, back) = if random.below(2) == 0 { (SEAL, 1) } else { (EARLIER, 0) };
                    self.put(now, Envelope::seal(&opened(&old), seal, sequence.saturating_sub(back)));
                }
            }
            LinkFault::Forge => {
                let mut forged = opened(&envelope);
                forge(&mut forged, &mut random);
                self.put(now, Envelope::seal(&forged, SEAL, sequence).in_attempt(envelope.attempt));
            }
        }
    }

    /// Whether its sender sends something now.
    fn speaks(&self) -> bool {
        self.stage.speaks(self.channel.from)
    }

    fn put(&self, at: Nanos, envelope: Envelope) {
        self.flight.borrow_mut().push((at, envelope));
        self.stage.wake_at(self.to, at);
    }

    /// Passes all envelopes that have arrived to `looks`, in their order; returns whether `looks` accepted any.
    fn take(&self, mut looks: impl FnMut(&Envelope) -> bool) -> bool {
        let now = self.stage.now.get();
        let mut taken = false;
        self.flight.borrow_mut().retain(|(at, envelope)| {
            if *at > now {
                self.stage.wake_at(self.to, *at);
                return true;
            }
            taken |= looks(envelope);
            false
        });
        taken
    }

    fn is_struck(&self) -> bool {
        let step = self.stage.now.get() / self.stage.step;
        let struck = self.stage.case.get().is_some_and(|case| case.is_at_work(step));
        self.stage.hits.set(self.stage.hits.get() + u64::from(struck));
        struck
    }

    fn remember(&self, envelope: Envelope) {
        if self.stage.remembers(self.channel) {
            let mut past = self.past.borrow_mut();
            past.push_back(envelope);
            if past.len() > REMEMBERED {
                past.pop_front();
            }
        }
    }
}

/// Reads the message back that this channel put into an envelope.
fn opened(envelope: &Envelope) -> Message {
    let mut message = Message::empty();
    envelope.open(&mut message).expect("whole");
    message
}

/// Inverts one to three bits of the header or of the words in use.
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
            // An envelope has no length beyond its body.
            3 => header.len = (header.len ^ 1 << (bit % 6)).min(WORDS as u32),
            4 => header.payload ^= 1 << bit,
            5 => header.dt = flip(header.dt),
            6 => header.duration = flip(header.duration),
            word => message.body[(word - 7) as usize] ^= 1 << bit,
        }
    }
}

/// The asking end of a port. `inner` is used only to wake the other end.
pub(super) struct FaultyClient {
    inner: Box<dyn Client>,
    requests: Rc<Direction>,
    replies: Rc<Direction>,
    numbers: numbering::Asking,
}

/// The answering end of a port.
pub(super) struct FaultyServer {
    inner: Box<dyn Server>,
    requests: Rc<Direction>,
    replies: Rc<Direction>,
    numbers: numbering::Answering,
}

/// Both ends of a port.
pub(super) fn faulty_port(
    (asking, answering): (Box<dyn Client>, Box<dyn Server>),
    requests: Direction,
    replies: Direction,
) -> (FaultyClient, FaultyServer) {
    let (requests, replies) = (Rc::new(requests), Rc::new(replies));
    let client = FaultyClient {
        inner: asking,
        requests: Rc::clone(&requests),
        replies: Rc::clone(&replies),
        numbers: numbering::Asking::new(SEAL),
    };
    let server =
        FaultyServer { inner: answering, requests, replies, numbers: numbering::Answering::new(SEAL) };
    (client, server)
}

impl FaultyClient {
    fn send_envelope(&self, envelope: Envelope) {
        self.requests.send(envelope);
        self.inner.send(&Message::empty());
    }
}

impl Client for FaultyClient {
    fn send(&self, request: &Message) {
        if self.requests.speaks() {
            self.send_envelope(self.numbers.ask(request));
        }
    }

    fn send_again(&self) {
        if self.requests.speaks()
            && let Some(envelope) = self.numbers.ask_again()
        {
            self.send_envelope(envelope);
        }
    }

    fn receive(&self, reply: &mut Message) -> bool {
        self.inner.receive(&mut Message::empty());
        self.replies.take(|shown| self.numbers.hears(shown, reply))
    }
}

impl FaultyServer {
    fn send_envelope(&self, envelope: Envelope) {
        self.replies.send(envelope);
        self.inner.reply(&Message::empty());
    }
}

impl Server for FaultyServer {
    fn receive(&self, request: &mut Message) -> bool {
        self.inner.receive(&mut Message::empty());
        self.requests.take(|shown| match self.numbers.hears(shown, request) {
            Disposition::New => true,
            Disposition::Again(answer) => {
                if self.replies.speaks() {
                    self.send_envelope(answer);
                }
                false
            }
            Disposition::Nothing => false,
        })
    }

    fn reply(&self, reply: &Message) {
        if self.replies.speaks() {
            self.send_envelope(self.numbers.answer(reply));
        }
    }
}

/// A board, which shows what arrived last.
pub(super) struct FaultyBoard {
    pub channel: Direction,
    pub shown: RefCell<Option<Message>>,
    pub sent: Cell<u64>,
}

impl Board for FaultyBoard {
    fn write(&self, message: &Message) {
        if self.channel.speaks() {
            self.sent.set(self.sent.get() + 1);
            self.channel.send(Envelope::seal(message, SEAL, self.sent.get()));
        }
    }

    fn read(&self, message: &mut Message) -> bool {
        let mut came = Message::empty();
        let opens = |shown: &Envelope| shown.is_under(SEAL) && shown.open(&mut came).is_ok();
        if self.channel.take(opens) {
            *self.shown.borrow_mut() = Some(came);
        }
        let shown = self.shown.borrow();
        shown.as_ref().is_some_and(|shown| {
            message.copy_from(shown);
            true
        })
    }
}
