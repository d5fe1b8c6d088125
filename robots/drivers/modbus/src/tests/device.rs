//! A device that is a table of bits and registers, behind a server of Modbus TCP.

use core::time::Duration;

use mrroc_driver_kit::testing;
use mrroc_driver_kit::testing::Reply;

/// How long after its gateway has given up a device answers all the same.
pub const LATE: Duration = Duration::from_millis(20);

/// An answer that is to come.
#[derive(Debug)]
struct Late {
    due: Duration,
    /// The first four bytes of its frame, and its unit.
    number: [u8; 4],
    unit: u8,
    answer: Vec<u8>,
    is_given_up: bool,
}

impl Late {
    fn frame(&self, number: &[u8; 4]) -> Vec<u8> {
        let length = (self.answer.len() as u16 + 1).to_be_bytes();
        [&number[..], &length, &[self.unit], &self.answer].concat()
    }
}

#[derive(Debug, Default)]
pub struct Device {
    pub inputs: [bool; 32],
    pub coils: [bool; 32],
    pub input_registers: [u16; 16],
    pub holding_registers: [u16; 16],
    /// What was written, in order: function, place, value.
    pub written: Vec<(u8, u16, u16)>,
    /// How often inputs were read, once in an exchange, and when something was asked last.
    pub exchanges: u32,
    pub asked_at: Duration,
    pub connections: usize,
    /// Whether what is written counts for nothing.
    pub is_stubborn: bool,
    pub is_silent: bool,
    /// An exception in place of every answer.
    pub exception: Option<u8>,
    /// Whether it closes the connection in place of the next answer.
    pub closes: bool,
    /// The function of which the gateway before it gives up the next question (exception 11); the answer then comes after [`LATE`].
    pub gives_up: Option<u8>,
    /// Whether that gateway gives what comes late the number of the question that is open then, and drops it where none is.
    pub renumbers: bool,
    /// How long the device takes.
    pub takes: Duration,
    /// What is on its serial line.
    line: Vec<Late>,
    /// What has come of the next question.
    came: Vec<u8>,
}

impl Device {
    /// The answer to a message.
    fn answer(&mut self, message: &[u8]) -> Vec<u8> {
        let word = |at: usize| u16::from_be_bytes([message[at], message[at + 1]]);
        let (function, at, what) = (message[0], word(1), word(3));
        if let Some(code) = self.exception {
            return vec![function | 0x80, code];
        }
        let places = usize::from(at)..usize::from(at) + usize::from(what);
        let bits = |all: &[bool; 32]| {
            let bytes = all[places.clone()]
                .chunks(8)
                .map(|eight| eight.iter().rev().fold(0, |byte, &on| byte << 1 | u8::from(on)));
            bytes.collect::<Vec<_>>()
        };
        let words =
            |all: &[u16; 16]| all[places.clone()].iter().flat_map(|word| word.to_be_bytes()).collect();
        let read: Vec<u8> = match function {
            1 => bits(&self.coils),
            2 => {
                self.exchanges += 1;
                bits(&self.inputs)
            }
            3 => words(&self.holding_registers),
            4 => words(&self.input_registers),
            _ => {
                self.written.push((function, at, what));
                if !self.is_stubborn {
                    match function {
                        5 => self.coils[usize::from(at)] = what == 0xff00,
                        _ => self.holding_registers[usize::from(at)] = what,
                    }
                }
                return message.to_vec();
            }
        };
        [&[function, read.len() as u8], &read[..]].concat()
    }
}

impl testing::Device for Device {
    fn connected(&mut self) {
        self.connections += 1;
        self.came.clear();
        self.line.clear();
    }

    fn poll(&mut self, now: Duration, received: &[u8], reply: &mut Reply) -> Duration {
        self.came.extend_from_slice(received);
        // All questions that are asked here have 12 bytes.
        while self.came.len() >= 12 {
            let question: Vec<u8> = self.came.drain(..12).collect();
            self.asked_at = now;
            reply.closes |= core::mem::take(&mut self.closes);
            if self.is_silent || reply.closes {
                continue;
            }
            let number = [question[0], question[1], question[2], question[3]];
            let (unit, answer) = (question[6], self.answer(&question[7..]));
            let is_given_up = self.gives_up.take_if(|function| *function == question[7]).is_some();
            if is_given_up {
                reply.bytes.extend([&number[..], &[0, 3, unit, question[7] | 0x80, 0x0b]].concat());
            }
            let due = now + if is_given_up { LATE } else { self.takes };
            self.line.push(Late { due, number, unit, answer, is_given_up });
        }
        while let Some(place) = self.line.iter().position(|late| late.due <= now) {
            let late = self.line.remove(place);
            if !(late.is_given_up && self.renumbers) {
                reply.bytes.extend(late.frame(&late.number));
            } else if let Some(open) = self.line.iter().position(|other| !other.is_given_up) {
                let open = self.line.remove(open);
                reply.bytes.extend(late.frame(&open.number));
            }
        }
        self.line.iter().map(|late| late.due).min().unwrap_or(Duration::MAX)
    }
}
