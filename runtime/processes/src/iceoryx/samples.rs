//! What is counted of a process, from its step to a thread that may lag.
//!
//! In: a sample from the one that waits. Out: samples in their order, to one reader. A ring of words of fixed size: writing
//! one takes no lock, no call of the system and no memory, and a sample that finds the ring full is dropped and counted.

use core::sync::atomic::{AtomicU64, Ordering};

use mrroc_core::link::Sample;

/// Samples that the ring holds: a second's at 1 kHz.
const LEN: usize = 4096;

/// The two highest bits of a word say what it counts.
const KIND: u32 = 62;

/// The ring. One thread pushes, one pops.
#[derive(Debug)]
pub(crate) struct Samples {
    words: Box<[AtomicU64]>,
    /// Samples pushed, and samples popped.
    pushed: AtomicU64,
    popped: AtomicU64,
    dropped: AtomicU64,
}

impl Samples {
    pub fn new() -> Samples {
        Samples {
            words: (0..LEN).map(|_| AtomicU64::new(0)).collect(),
            pushed: AtomicU64::new(0),
            popped: AtomicU64::new(0),
            dropped: AtomicU64::new(0),
        }
    }

    /// Keeps a sample, if there is room.
    pub fn push(&self, sample: Sample) {
        let pushed = self.pushed.load(Ordering::Relaxed);
        // What the reader has popped is free: its reads come before its count.
        if pushed - self.popped.load(Ordering::Acquire) >= LEN as u64 {
            self.dropped.fetch_add(1, Ordering::Relaxed);
            return;
        }
        let (kind, value) = match sample {
            Sample::Late(time) => (0, time),
            Sample::Worked(time) => (1, time),
            Sample::Skipped(periods) => (2, periods),
        };
        let word = kind << KIND | value.min((1 << KIND) - 1);
        self.words[pushed as usize % LEN].store(word, Ordering::Relaxed);
        self.pushed.store(pushed + 1, Ordering::Release);
    }

    /// The oldest sample.
    pub fn pop(&self) -> Option<Sample> {
        let popped = self.popped.load(Ordering::Relaxed);
        if popped == self.pushed.load(Ordering::Acquire) {
            return None;
        }
        let word = self.words[popped as usize % LEN].load(Ordering::Relaxed);
        self.popped.store(popped + 1, Ordering::Release);
        let value = word & ((1 << KIND) - 1);
        Some(match word >> KIND {
            0 => Sample::Late(value),
            1 => Sample::Worked(value),
            _ => Sample::Skipped(value),
        })
    }

    /// Samples that found no room.
    pub fn dropped(&self) -> u64 {
        self.dropped.load(Ordering::Relaxed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_come_out_as_they_went_in_and_what_finds_no_room_is_counted() {
        let samples = Samples::new();
        let sample = |i: u64| match i % 3 {
            0 => Sample::Late(i),
            1 => Sample::Worked(i),
            _ => Sample::Skipped(i),
        };
        for round in 0..3 {
            let all = LEN as u64 + 5;
            (0..all).for_each(|i| samples.push(sample(i)));
            assert_eq!(samples.dropped(), 5 * (round + 1));
            for i in 0..LEN as u64 {
                assert_eq!(samples.pop(), Some(sample(i)));
            }
            assert_eq!(samples.pop(), None);
        }
    }

    #[test]
    fn a_reader_that_lags_sees_every_sample_that_was_not_dropped_once_and_in_order() {
        let samples = Samples::new();
        let last = 100_000;
        std::thread::scope(|scope| {
            scope.spawn(|| (1..=last).for_each(|i| samples.push(Sample::Late(i))));
            let (mut seen, mut before) = (0, 0);
            while seen + samples.dropped() < last {
                while let Some(Sample::Late(i)) = samples.pop() {
                    assert!(i > before, "{i} after {before}");
                    (seen, before) = (seen + 1, i);
                }
            }
            assert_eq!(seen + samples.dropped(), last);
        });
    }
}
