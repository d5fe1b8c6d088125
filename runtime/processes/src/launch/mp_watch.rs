//! Watches over an MP that begins no step.
//!
//! In: the MP's step and instruction, as it shows them. Out: whether it is to be told that the MP stands still, and whether
//! the cell is to be ended. While an MP begins no step its robots stand: its program computes, or is kept from running. The
//! launcher's own pauses are not counted.

use std::time::{Duration, Instant};

use crate::consoles::STOPPING;

/// The share of its timeout after which the launcher tells of an MP that stands still.
const TELLING: u32 = 6;

/// The most time that one look counts.
const LOOK: Duration = Duration::from_millis(500);

/// What an MP's silence means.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Still {
    /// It has begun a step since the last look.
    Moves,
    /// It stands still for less time than it may, or that has been told already.
    Tolerated,
    /// It has stood still for so long that it is to be told of \[s\].
    ToBeTold(f64),
    /// It has stood still for longer than it may \[s\].
    ToBeEnded(f64),
}

/// How far an MP has come.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct MpProgress {
    /// Its step.
    pub step: u64,
    /// The Moves and Waits that it has begun.
    pub instructions: u64,
}

/// What the launcher has seen of its MP.
pub(super) struct MpWatch {
    timeout: Duration,
    /// How far it had come at the last look.
    progress: MpProgress,
    looked: Option<Instant>,
    /// How long it has stood still.
    still: Duration,
    /// The number of the operator's stop that the MP has not carried out yet, and how long it has not.
    stopping: Option<(u64, Duration)>,
    is_told: bool,
}

impl MpWatch {
    /// Of an MP whose program may compute for `timeout`.
    pub const fn new(timeout: Duration) -> MpWatch {
        MpWatch {
            timeout,
            progress: MpProgress { step: 0, instructions: 0 },
            looked: None,
            still: Duration::ZERO,
            stopping: None,
            is_told: false,
        }
    }

    /// Notes that the operator has pressed stop, under a number that is larger than that of earlier presses.
    pub fn note_stop(&mut self, number: u64) {
        self.stopping.get_or_insert((number, Duration::ZERO));
    }

    /// Whether the operator has pressed stop, and the MP has not carried that out.
    pub const fn is_stopping(&self) -> bool {
        self.stopping.is_some()
    }

    /// Looks at how far the MP has come, and at the number of the stop that it has carried out last.
    pub fn look(&mut self, progress: MpProgress, stopped: u64, now: Instant) -> Still {
        self.stopping = self.stopping.filter(|(number, _)| *number > stopped);
        let passed = self.looked.replace(now).map_or(Duration::ZERO, |last| (now - last).min(LOOK));
        if self.progress != progress {
            let MpWatch { looked, stopping, .. } = *self;
            *self = MpWatch { progress, looked, stopping, ..MpWatch::new(self.timeout) };
            return Still::Moves;
        }
        self.still += passed;
        let mut is_over = self.still >= self.timeout;
        if let Some((_, since)) = &mut self.stopping {
            *since += passed;
            is_over |= *since >= STOPPING;
        }
        let seconds = (self.still.as_secs_f64() * 10.0).round() / 10.0;
        if is_over {
            return Still::ToBeEnded(seconds);
        }
        if self.is_told || self.still < self.timeout / TELLING {
            return Still::Tolerated;
        }
        self.is_told = true;
        Still::ToBeTold(seconds)
    }

    /// Counts from now on.
    pub fn begin_again(&mut self) {
        *self = MpWatch::new(self.timeout);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(step: u64) -> MpProgress {
        MpProgress { step, instructions: 1 }
    }

    /// Looks ten times a second at an MP that stands still; after how many looks it is told, and ended.
    fn looks(watch: &mut MpWatch, stop_at: Option<u32>) -> (Option<u32>, u32) {
        let begin = Instant::now();
        let (mut told, tenth) = (None, Duration::from_millis(100));
        for i in 0_u32.. {
            if stop_at == Some(i) {
                watch.note_stop(3);
            }
            match watch.look(at(7), 2, begin + i * tenth) {
                Still::Moves | Still::Tolerated => {}
                Still::ToBeTold(_) => assert_eq!(told.replace(i), None, "told once"),
                Still::ToBeEnded(_) => return (told, i),
            }
        }
        unreachable!("it is ended")
    }

    #[test]
    fn an_mp_that_stands_still_is_told_after_a_sixth_of_its_time_and_ended_after_it() {
        let mut watch = MpWatch::new(Duration::from_secs(60));
        assert_eq!(looks(&mut watch, None), (Some(100), 600));
    }

    #[test]
    fn an_mp_that_was_told_to_stop_is_ended_sooner() {
        let mut watch = MpWatch::new(Duration::from_secs(60));
        assert_eq!(looks(&mut watch, Some(20)), (None, 69));
        // One that begins a step has not carried the stop out yet.
        assert_eq!(watch.look(at(8), 2, Instant::now()), Still::Moves);
        assert!(watch.is_stopping());
        assert_eq!(watch.look(at(9), 3, Instant::now()), Still::Moves);
        assert!(!watch.is_stopping());
    }

    #[test]
    fn a_pause_of_the_launcher_is_not_the_mps() {
        let (mut watch, begin) = (MpWatch::new(Duration::from_secs(60)), Instant::now());
        let pauses = (0..100).map(|i| watch.look(at(7), 0, begin + i * Duration::from_secs(600)));
        assert!(pauses.into_iter().all(|still| !matches!(still, Still::ToBeEnded(_))));
    }
}
