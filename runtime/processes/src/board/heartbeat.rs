//! The launcher's heartbeat, by which the MP notices that nobody supervises its cell.
//!
//! In: a number in shared memory that the launcher changes as long as it supervises. Out: in the MP, whether the launcher
//! stands still. Silence is counted by the MP's own looks, so that a machine that stood still as a whole, or a program that
//! computes between two looks, is not taken for a launcher that stands still.

use core::cell::Cell;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use mrroc_core::link::Nanos;

/// The longest time between two beats.
pub(crate) const BEAT: Duration = Duration::from_millis(100);

/// The silence after which a launcher counts as standing still \[ns\].
const SILENCE: Nanos = 1_000_000_000;

/// The most silence that one look counts \[ns\].
const LOOK: Nanos = 50_000_000;

/// The launcher has suspended the cell and sleeps until its user continues it.
const ASLEEP: u64 = 1 << 63;

/// The number in shared memory.
#[repr(transparent)]
pub(crate) struct Heartbeat(AtomicU64);

impl Heartbeat {
    /// Shows that the launcher supervises. Only the launcher calls this.
    pub fn beat(&self) {
        self.0.store((self.0.load(Ordering::Relaxed) & !ASLEEP) + 1, Ordering::Release);
    }

    /// Shows that the launcher will sleep, on purpose, while the cell is suspended; the next beat ends that.
    pub fn sleep(&self) {
        self.0.fetch_or(ASLEEP, Ordering::AcqRel);
    }

    /// The number, as a process reads it.
    pub fn read(&self) -> u64 {
        self.0.load(Ordering::Acquire)
    }
}

/// What the MP has seen of the heartbeat.
#[derive(Debug, Default)]
pub(crate) struct Silence {
    beats: Cell<u64>,
    /// When it looked last \[ns\].
    looked: Cell<Nanos>,
    /// The silence counted so far \[ns\].
    silence: Cell<Nanos>,
}

impl Silence {
    /// Looks at the heartbeat at a time \[ns\]; returns whether the launcher stands still.
    pub fn look(&self, beats: u64, now: Nanos) -> bool {
        let passed = now.saturating_sub(self.looked.replace(now)).min(LOOK);
        let is_silent = self.beats.replace(beats) == beats && beats & ASLEEP == 0;
        self.silence.set(if is_silent { self.silence.get() + passed } else { 0 });
        self.silence.get() >= SILENCE
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const STEP: Nanos = 2_000_000;

    #[test]
    fn a_launcher_is_missed_after_a_second_of_steps_without_a_beat_and_found_again_with_the_next_one() {
        let (heartbeat, silence) = (Heartbeat(AtomicU64::new(0)), Silence::default());
        let look = |step: u64| silence.look(heartbeat.read(), step * STEP);
        heartbeat.beat();
        assert!((0..500).all(|step| !look(step)));
        assert!(look(500));
        heartbeat.beat();
        assert!(!look(501));
    }

    #[test]
    fn a_pause_of_the_machine_or_a_program_that_computes_is_no_silence() {
        let (heartbeat, silence) = (Heartbeat(AtomicU64::new(0)), Silence::default());
        heartbeat.beat();
        assert!(!silence.look(heartbeat.read(), 0));
        // Ten minutes each.
        assert!((1..20).all(|pause| !silence.look(heartbeat.read(), pause * 600_000_000_000)));
    }

    #[test]
    fn a_launcher_that_sleeps_on_purpose_is_not_missed_until_it_wakes() {
        let (heartbeat, silence) = (Heartbeat(AtomicU64::new(0)), Silence::default());
        let look = |step: u64| silence.look(heartbeat.read(), step * STEP);
        heartbeat.beat();
        heartbeat.sleep();
        assert!((0..10_000).all(|step| !look(step)));
        heartbeat.beat();
        assert!((10_000..10_500).all(|step| !look(step)));
        assert!(look(10_500));
    }
}
