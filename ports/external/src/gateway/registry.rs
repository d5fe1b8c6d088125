//! Who is at the gateway, whose readings count, and the newest of them.
//!
//! In: what programs send, and which of them are there. Out: messages as a program on this machine would send them, with times
//! of this machine's clock. The first program that sends something counts for as long as it is there; no other one
//! replaces it. A message that is none is passed on as one of version 0, so that the sensor says so.

use super::clock::Clock;
use super::frame::ProgramMessage;
use crate::message::Message;

/// So many programs at most are known at a time.
const PROGRAMS: usize = 16;

/// What a message that is none is passed on as.
const NONE: u32 = 0;

#[derive(Debug, Default)]
pub(crate) struct ProgramRegistry {
    /// Those that are there, in the order in which they came.
    programs: Vec<u64>,
    holder: Option<u64>,
    clock: Clock,
    newest: Option<Message>,
}

impl ProgramRegistry {
    /// A program is there. Number 0 is nobody's.
    pub fn is_there(&mut self, program: u64) {
        if program != 0 && !self.programs.contains(&program) && self.programs.len() < PROGRAMS {
            self.programs.push(program);
        }
    }

    /// A program has ended, or cannot be reached.
    pub fn is_lost(&mut self, program: u64) {
        self.programs.retain(|&known| known != program);
        if self.holder == Some(program) {
            self.holder = None;
        }
    }

    /// Whose readings count; 0 for nobody's.
    pub fn holder(&self) -> u64 {
        self.holder.unwrap_or(0)
    }

    /// Something has come at this time.
    pub fn came(&mut self, bytes: &[u8], now: u64) {
        let Some(said) = ProgramMessage::read(bytes) else { return };
        if !self.programs.contains(&said.program) {
            return;
        }
        if self.holder.is_none() {
            (self.holder, self.clock) = (Some(said.program), Clock::default());
        }
        if self.holder != Some(said.program) {
            return;
        }
        if said.sent != 0 {
            self.clock.heard(said.sent, said.came, now);
        }
        let Some(mut message) = said.message else {
            self.newest = Some(Message { version: NONE, time: now, ..Message::EMPTY });
            return;
        };
        // What was measured before an order came cannot be dated yet.
        if let Some(time) = self.clock.here(message.time) {
            message.time = time;
            self.newest = Some(message);
        }
    }

    /// The newest message since the last call.
    pub fn take(&mut self) -> Option<Message> {
        self.newest.take()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::message::VERSION;

    /// What program `program` says, with a reading that was measured at a time.
    fn said(program: u64, [sent, came]: [u64; 2], time: u64) -> Vec<u8> {
        let message = Message { len: 1, time, words: [42; 64], ..Message::EMPTY };
        let mut bytes = [program, sent, came].map(u64::to_le_bytes).concat();
        bytes.extend_from_slice(&super::super::frame::order(0, 0, &message)[16..]);
        bytes
    }

    #[test]
    fn fault_158_the_first_program_at_a_gateway_counts_until_it_is_gone_and_no_second_one_before() {
        let mut registry = ProgramRegistry::default();
        registry.is_there(7);
        registry.is_there(8);
        assert_eq!(registry.holder(), 0, "nobody has sent anything");
        registry.came(&said(9, [100, 100], 100), 100);
        assert_eq!((registry.holder(), registry.take()), (0, None), "9 is not there");
        registry.came(&said(8, [100, 1100], 1150), 200);
        assert_eq!(registry.holder(), 8);
        let taken = registry.take().expect("a message");
        assert_eq!((taken.version, taken.time, taken.words[0]), (VERSION, 150, 42), "by the clock of here");
        registry.came(&said(7, [100, 100], 150), 300);
        assert_eq!((registry.holder(), registry.take()), (8, None));
        registry.is_lost(7);
        assert_eq!(registry.holder(), 8);
        registry.is_there(7);
        registry.is_lost(8);
        registry.came(&said(8, [100, 1100], 1250), 300);
        assert_eq!((registry.holder(), registry.take()), (0, None), "8 is gone");
        registry.came(&said(7, [100, 100], 350), 400);
        assert_eq!(
            (registry.holder(), registry.take().map(|taken| taken.time)),
            (7, Some(350)),
            "with a clock of its own"
        );
    }

    #[test]
    fn fault_157_what_is_no_message_is_passed_on_as_one_of_another_version_and_what_has_no_time_is_not() {
        let mut registry = ProgramRegistry::default();
        registry.is_there(7);
        registry.came(&said(7, [0, 0], 5), 100);
        assert_eq!(registry.take(), None, "it has got no order yet");
        registry.came(&said(7, [100, 50], 60), 120);
        assert_eq!(registry.take().map(|taken| taken.time), Some(110));
        registry.came(&said(7, [100, 50], 60)[..100], 130);
        assert_eq!(registry.take().map(|taken| (taken.version, taken.time)), Some((0, 130)));
        // Crowds and nobody are not let in.
        (0..100).for_each(|program| registry.is_there(program));
        assert!(registry.programs.len() <= PROGRAMS && !registry.programs.contains(&0));
    }
}
