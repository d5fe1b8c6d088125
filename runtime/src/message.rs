//! The messages between processes: one plain envelope for every link.

use crate::limits::RateHeadroom;
use crate::wire::WORDS;

/// What a message is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Tell me your state; nothing moves. To an ECP and to an EDP.
    Query,
    /// Opens an instruction. Body: nothing; `payload` names the type of its orders. MP to ECP.
    Start,
    /// One step of the open instruction. Body: the order. MP to ECP.
    Step,
    /// Ends the open instruction. MP to ECP.
    End,
    /// Ends the open instruction at standstill with `Aborted`. MP to ECP.
    Abort,
    /// Stop and latch. To an ECP and to an EDP.
    Stop,
    /// The demand of one step. Body: the demand. ECP to EDP.
    Demand,
    /// Come to a standstill from the last demand and hold. ECP to EDP.
    Brake,
    /// Take a reading. Body: configuration, then the associated robot's state. To a VSP.
    Read,
    /// The answer to any of these. Body: the image of the robot, or the reading.
    Reply,
    /// The answer when something is wrong. Body: the fault.
    Fault,
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
}

/// The head of a message.
#[derive(Clone, Copy, Debug)]
pub struct Header {
    /// What it is about.
    pub kind: Kind,
    /// Bits of [`flag`].
    pub flags: u32,
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
    pub headroom: RateHeadroom,
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
    /// A message without a body.
    pub const fn new(kind: Kind) -> Message {
        let header = Header {
            kind,
            flags: 0,
            step: 0,
            instruction: 0,
            len: 0,
            payload: 0,
            dt: 0.0,
            duration: 0.0,
            headroom: RateHeadroom::UNLIMITED,
        };
        Message { header, body: [0; WORDS] }
    }

    /// Whether a flag is set.
    pub const fn is(&self, flag: u32) -> bool {
        self.header.flags & flag != 0
    }

    /// The words that count.
    pub fn words(&self) -> &[u64] {
        &self.body[..(self.header.len as usize).min(WORDS)]
    }

    /// Copies head and the words that count.
    pub fn copy_from(&mut self, other: &Message) {
        self.header = other.header;
        let len = (other.header.len as usize).min(WORDS);
        self.body[..len].copy_from_slice(&other.body[..len]);
    }
}
