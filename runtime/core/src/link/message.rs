//! The messages between processes: one plain envelope for every link.

use crate::model::fault::{Fault, FaultKind, FaultWords};
use crate::model::wire::{WORDS, Wire};
use crate::safety::braking::BrakingLaw;
use crate::safety::rate::RateMargin;

/// What a message is about, and with it who may send it to whom.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// MP to ECP.
    Order(OrderKind),
    /// ECP to EDP.
    Request(RequestKind),
    /// EDP to the plant: what simulated drives are to do in a servo period. Body: which choice of regulators it is, the
    /// regulators, the joint positions.
    Command,
    /// To a VSP: take a reading. Body: configuration, then the associated robot's state.
    Read,
    /// The answer to any of these. Body: the image of the robot, or the reading.
    Reply,
    /// The answer when something is wrong. Body: the fault.
    Fault,
}

/// What an MP tells an ECP.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OrderKind {
    /// Tell me your state; nothing moves.
    Query,
    /// Opens an instruction. Body: nothing; `payload` names the type of its orders.
    Start,
    /// One step of the open instruction. Body: the order.
    Step,
    /// Ends the open instruction.
    End,
    /// Ends the open instruction at standstill with `Aborted`.
    Abort,
    /// Come to a standstill: no instruction takes the moving robot over.
    Brake,
    /// Stop and latch.
    Stop,
    /// Leave the latch, with the order's new epoch: drives on, nothing moves, the program starts again.
    Reset,
}

impl OrderKind {
    /// Its word.
    #[must_use]
    pub const fn word(self) -> &'static str {
        match self {
            OrderKind::Query => "query",
            OrderKind::Start => "start",
            OrderKind::Step => "step",
            OrderKind::End => "end",
            OrderKind::Abort => "abort",
            OrderKind::Brake => "brake",
            OrderKind::Stop => "stop",
            OrderKind::Reset => "reset",
        }
    }
}

/// What an ECP tells its EDP.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RequestKind {
    /// Tell me your state; nothing moves.
    Query,
    /// The demand of one step. Body: the demand.
    Demand,
    /// Come to a standstill from the last demand and hold.
    Brake,
    /// Stop and latch.
    Stop,
    /// Leave the latch: hold where the robot is.
    Reset,
}

/// Facts that a message states by a bit.
pub mod flag {
    /// The sender wants the robot's image in the reply.
    pub const WANT_STATE: u32 = 1;
    /// The first demand of a motion.
    pub const FIRST: u32 = 1 << 1;
    /// The reply holds the robot's image.
    pub const STATE: u32 = 1 << 2;
    /// The ECP's program has finished the open instruction.
    pub const FINISHED: u32 = 1 << 3;
    /// The ECP has left the instruction that was ended.
    pub const ENDED: u32 = 1 << 4;
    /// The robot stands still and its EDP holds.
    pub const STANDSTILL: u32 = 1 << 5;
    /// The instruction ended while moving: the next one takes over in this very step.
    pub const BLEND: u32 = 1 << 6;
    /// The operator has suspended the cell: a Wait waits on without looking.
    pub const SUSPENDED: u32 = 1 << 7;
    /// The robot's drives still look for their reference marks: it has no state yet.
    pub const HOMING: u32 = 1 << 8;
    /// The order is one of several robots that move together: without the next ones each stops on its twist. In a reply: the robot
    /// does so.
    pub const TOGETHER: u32 = 1 << 9;
    /// The robot still moves on its path but is to stop on it. Body: the fault, in place of the image.
    pub const TROUBLE: u32 = 1 << 10;
    /// In an order to stop: the operator resets the cell, and it is this robot's turn to recover from a stop of its own.
    pub const RECOVER: u32 = 1 << 11;
    /// The cell is at reduced speed: no demand may move the tool faster than that.
    pub const REDUCED: u32 = 1 << 13;
    /// An abort ends the instruction: the robot's outputs take the values that the cell declares for a stop.
    pub const ABORTED: u32 = 1 << 14;
    /// In an order to stop: a robot has not answered the order of the step before, of several that move together. Whether that
    /// has come to it is not known.
    pub const UNANSWERED: u32 = 1 << 15;
    /// In an order: what is asked of the robot that a person jogs is behind the order's own words.
    pub const JOG: u32 = 1 << 16;
    /// In a reply: the program of the ECP lets the robot be jogged now.
    pub const JOGS: u32 = 1 << 17;
    /// In a reply: the program of the ECP moves the robot, and no jog panel says how.
    pub const OWN_MOTION: u32 = 1 << 18;
    /// The robot still recovers, or its EDP has not answered whether it does.
    pub const RECOVERS: u32 = 1 << 12;
}

/// The head of a message.
#[derive(Clone, Copy, Debug)]
pub struct Header {
    /// What it is about.
    pub kind: Kind,
    /// Bits of [`flag`].
    pub flags: u32,
    /// Resets of the cell that were tried before it was sent: of an earlier epoch it moves nothing.
    pub epoch: u32,
    /// Index of the step that it belongs to.
    pub step: u64,
    /// Ordinal of the instruction that it belongs to.
    pub instruction: u32,
    /// Words used in the body.
    pub len: u32,
    /// Identity of the type in the body.
    pub payload: u64,
    /// Path time of the step \[s\].
    pub dt: f64,
    /// Real time of the step \[s\].
    pub duration: f64,
    /// In a reply: how fast the rate may change within the robot's limits.
    pub rate_margin: RateMargin,
    /// In a reply: how fast the robot may slow down on its twist. In an order and a request: how fast all robots of the
    /// instruction may.
    pub law: BrakingLaw,
}

impl Header {
    /// Says which message it answers: that of this head.
    #[inline]
    pub(crate) const fn answer(&mut self, asked: &Header) {
        self.epoch = asked.epoch;
        self.step = asked.step;
        self.instruction = asked.instruction;
    }

    /// Whether a process in its senses could have sent these numbers: path time passes no faster than time, and no
    /// robot's limits are negative. A rate beyond 1 would let all robots' limits be negative, and the rate jump.
    pub(crate) fn is_sound(&self) -> bool {
        // Quotients and products of times are rounded.
        const ROUND_OFF: f64 = 1e-9;
        let RateMargin { rise, fall, bend, full, most } = self.rate_margin;
        let bounds = [rise, fall, bend, full.rise, full.bend, most, self.law.fall, self.law.bend];
        let times =
            self.dt >= 0.0 && self.dt <= self.duration * (1.0 + ROUND_OFF) && self.duration.is_finite();
        times && bounds.into_iter().all(|bound| bound >= 0.0)
    }
}

/// A message: what every link carries.
#[derive(Clone, Copy, Debug)]
pub struct Message {
    /// The head.
    pub header: Header,
    /// The body, of which `header.len` words count.
    pub body: [u64; WORDS],
}

impl Message {
    /// A place for a message to come.
    pub const fn empty() -> Message {
        Message::new(Kind::Reply)
    }

    /// A message without a body.
    pub const fn new(kind: Kind) -> Message {
        let header = Header {
            kind,
            flags: 0,
            epoch: 0,
            step: 0,
            instruction: 0,
            len: 0,
            payload: 0,
            dt: 0.0,
            duration: 0.0,
            rate_margin: RateMargin::UNLIMITED,
            law: BrakingLaw::UNLIMITED,
        };
        Message { header, body: [0; WORDS] }
    }

    /// Whether a flag is set.
    #[inline]
    pub const fn is(&self, flag: u32) -> bool {
        self.header.flags & flag != 0
    }

    /// The words that count.
    #[inline]
    pub fn words(&self) -> &[u64] {
        &self.body[..(self.header.len as usize).min(WORDS)]
    }

    /// Makes it the report of a fault.
    pub fn set_fault(&mut self, fault: &Fault) {
        self.header.kind = Kind::Fault;
        self.header.len = FaultWords::LEN as u32;
        FaultWords::from(fault).put(&mut self.body);
    }

    /// The fault that it reports, or that it cannot be read as one.
    pub fn fault(&self) -> Fault {
        FaultWords::get(self.words()).map_or_else(|_| Fault::new(FaultKind::Message), Fault::from)
    }

    /// Copies head and the words that count, and maybe words that do not.
    #[inline]
    pub fn copy_from(&mut self, other: &Message) {
        // Most bodies are a demand or nothing: so many words are copied without a call, whether they count or not.
        const SHORT: usize = 8;
        self.header = other.header;
        let (to, from) = (self.body.split_at_mut(SHORT), other.body.split_at(SHORT));
        to.0.copy_from_slice(from.0);
        let longer = (other.header.len as usize).min(WORDS).saturating_sub(SHORT);
        if longer > 0 {
            to.1[..longer].copy_from_slice(&from.1[..longer]);
        }
    }
}
