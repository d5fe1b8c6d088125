//! A gripper that is a model of its registers, behind a server of Modbus TCP.

use core::time::Duration;

use mrroc_driver_kit::testing::{Device, Reply};

/// A gripper: its registers, and fingers that go on by some numbers whenever its status is read.
#[derive(Debug)]
pub struct Gripper {
    pub request: [u16; 3],
    pub is_active: bool,
    /// Readings that an activation takes, and those until it is over.
    pub takes: u32,
    pub activation: u32,
    pub position: u8,
    pub told: u8,
    pub goes: bool,
    /// Where something stops fingers that close.
    pub object: u8,
    pub held: bool,
    pub fault: u8,
    /// Whether its fingers never stand.
    pub is_restless: bool,
    /// Where somebody else tells the fingers to go, after each of our requests.
    pub others: Option<u8>,
    /// What was written, in order.
    pub written: Vec<[u16; 3]>,
    /// When something was written last, and asked last; how often its status was read.
    pub written_at: Duration,
    pub asked_at: Duration,
    pub reads: u32,
    pub connections: usize,
    /// Bytes in place of the next answer.
    pub instead: Option<Vec<u8>>,
    /// An exception in place of every answer.
    pub exception: Option<u8>,
    /// Whether it says nothing any more.
    pub is_silent: bool,
    /// Whether it closes the connection in place of the next answer.
    pub closes: bool,
    /// What has come of the next question.
    pub came: Vec<u8>,
}

impl Gripper {
    pub const ACTIVE: Gripper = Gripper {
        request: [0x0900, 40, 0],
        is_active: true,
        takes: 5,
        activation: 0,
        position: 40,
        told: 40,
        goes: true,
        object: 255,
        held: false,
        fault: 0,
        is_restless: false,
        others: None,
        written: Vec::new(),
        written_at: Duration::ZERO,
        asked_at: Duration::ZERO,
        reads: 0,
        connections: 0,
        instead: None,
        exception: None,
        is_silent: false,
        closes: false,
        came: Vec::new(),
    };

    pub fn inactive() -> Gripper {
        Gripper { is_active: false, request: [0; 3], goes: false, ..Gripper::ACTIVE }
    }

    pub fn write(&mut self, request: [u16; 3]) {
        self.written.push(request);
        self.request = request;
        let activates = request[0] & 0x0100 != 0;
        if !activates {
            (self.is_active, self.activation, self.fault, self.goes) = (false, 0, 0, false);
        } else if !self.is_active && self.activation == 0 {
            self.activation = self.takes;
        }
        if self.is_active && request[0] & 0x0800 != 0 {
            (self.goes, self.told) = (true, request[1] as u8);
        }
    }

    fn read(&mut self) -> [u16; 3] {
        self.reads += 1;
        self.told = self.others.unwrap_or(self.told);
        if self.activation > 0 {
            self.activation -= 1;
            (self.is_active, self.position) = (self.activation == 0, 3);
        }
        if self.is_active && self.goes {
            let remaining = i16::from(self.told) - i16::from(self.position);
            let next = i16::from(self.position) + remaining.clamp(-8, 8);
            self.held = remaining > 0 && next > i16::from(self.object);
            self.position = if self.held { self.object } else { next as u8 };
        }
        let fingers = match self.told == self.position && !self.is_restless {
            _ if self.held => 2,
            true => 3,
            false => 0,
        };
        let state = match (self.is_active, self.request[0] & 0x0100 != 0) {
            (true, _) => 0x31,
            (false, true) => 0x11,
            (false, false) => 0,
        };
        let status = state | u16::from(self.goes) << 3 | fingers << 6;
        let fault = u16::from(self.fault) << 8;
        [status << 8, fault | u16::from(self.told), u16::from(self.position) << 8 | 12]
    }

    /// The question at the front of what has come: its header, and the message after the function.
    fn question(&mut self) -> Option<(Vec<u8>, Vec<u8>)> {
        let len = 6 + usize::from(u16::from_be_bytes([*self.came.get(4)?, *self.came.get(5)?]));
        if self.came.len() < len {
            return None;
        }
        let mut frame: Vec<u8> = self.came.drain(..len).collect();
        let message = frame.split_off(8);
        Some((frame, message))
    }

    fn answer(&mut self, now: Duration, function: u8, message: &[u8]) -> Vec<u8> {
        if let Some(code) = self.exception {
            return vec![function | 0x80, code];
        }
        let word = |at: usize| u16::from_be_bytes([message[at], message[at + 1]]);
        match function {
            0x10 => {
                assert_eq!((word(0), word(2), message[4]), (0x03e8, 3, 6));
                self.write([word(5), word(7), word(9)]);
                self.written_at = now;
                [&[function], &message[..4]].concat()
            }
            0x04 => {
                assert_eq!((word(0), word(2)), (0x07d0, 3));
                let words = self.read().map(u16::to_be_bytes);
                [&[function, 6], words.as_flattened()].concat()
            }
            other => panic!("function {other}"),
        }
    }
}

impl Device for Gripper {
    fn connected(&mut self) {
        self.connections += 1;
        self.came.clear();
    }

    fn poll(&mut self, now: Duration, received: &[u8], reply: &mut Reply) -> Duration {
        self.came.extend_from_slice(received);
        while let Some((mut head, message)) = self.question() {
            self.asked_at = now;
            reply.closes |= core::mem::take(&mut self.closes);
            if self.is_silent || reply.closes {
                continue;
            }
            if let Some(instead) = self.instead.take() {
                reply.bytes.extend(instead);
                continue;
            }
            let answer = self.answer(now, head[7], &message);
            head.truncate(7);
            head[4..6].copy_from_slice(&(1 + answer.len() as u16).to_be_bytes());
            reply.bytes.extend([head, answer].concat());
        }
        Duration::MAX
    }
}
