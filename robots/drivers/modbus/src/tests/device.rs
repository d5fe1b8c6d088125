//! A device that is a table of bits and registers, behind a server of Modbus TCP.

use core::time::Duration;

use mrroc_driver_kit::testing;
use mrroc_driver_kit::testing::Reply;

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
            let answer = self.answer(&question[7..]);
            let length = (answer.len() as u16 + 1).to_be_bytes();
            reply.bytes.extend([&question[..4], &length, &question[6..7], &answer].concat());
        }
        Duration::MAX
    }
}
