//! The ring that carries samples of a process's timing from its step to a thread that may lag.
//!
//! In: samples from the thread that waits and steps. Out: the samples in their order, to one reader. The ring has a
//! fixed number of words: writing a sample takes no lock, no system call and no allocation; when the ring is full, the
//! sample is dropped and counted.

use core::sync::atomic::{AtomicU64, Ordering};

use mrroc_core::link::Sample;

/// Number of samples that the ring holds: those of a second at 1 kHz.
const LEN: usize = 4096;

/// The two highest bits of a word say which kind of sample it is.
const KIND: u32 = 62;

/// The ring. One thread pushes and one thread pops.
#[derive(Debug)]
pub(crate) struct Samples {
    words: Box<[AtomicU64]>,
    /// Number of samples pushed.
    pushed: AtomicU64,
    /// Number of samples popped.
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

    /// Puts a sample into the ring, or counts it as dropped when the ring is full.
    pub fn push(&self, sample: Sample) {
        let pushed = self.pushed.load(Ordering::Relaxed);
        // A word that the reader has popped is free: the reader reads it before it raises its count.
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

    /// Takes the oldest sample.
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

    /// Number of samples that were dropped.
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
