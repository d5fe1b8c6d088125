//! Notes to a user who waits for a run that may never end.
//!
//! In: the steps of a run and the wall clock. Out: notes at growing intervals.

#![expect(clippy::disallowed_methods, reason = "it tells a user how long a run has taken")]

use std::time::{Duration, Instant};

use super::outcome::note;
use mrroc_core::operator::Operator;

/// Prints notes about a run that may never end, at growing intervals.
pub struct Patience {
    since: Instant,
    next: Duration,
}

impl Patience {
    /// Begins to wait; the first note is due after 10 s.
    pub fn begin() -> Patience {
        Patience { since: Instant::now(), next: Duration::from_secs(10) }
    }

    /// The hook for every step, which looks at the wall clock from time to time and prints the notes.
    pub fn notes(mut self) -> impl FnMut(u64, &Operator) {
        move |step, _| {
            if step % 1024 == 0
                && let Some(text) = self.after(self.since.elapsed(), step)
            {
                note(&text);
            }
        }
    }

    /// The note about a run that is in this step after this time, if one is due.
    fn after(&mut self, elapsed: Duration, step: u64) -> Option<String> {
        if elapsed < self.next {
            return None;
        }
        self.next = elapsed * 2;
        Some(format!(
            "still running after {} s, in step {step}: a motion ends where its step function returns `Step::Done`, a Wait \
             where its condition holds; stop the program by Ctrl-C",
            elapsed.as_secs()
        ))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_run_without_an_end_is_told_of_ever_more_seldom() {
        let mut patience = Patience::begin();
        let told: Vec<_> = (0..100)
            .filter(|&second| patience.after(Duration::from_secs(second), second * 500).is_some())
            .collect();
        assert_eq!(told, [10, 20, 40, 80]);
        let text = patience.after(Duration::from_secs(160), 80_000).expect("160 s is twice 80 s");
        assert!(text.contains("160 s, in step 80000") && text.contains("`Step::Done`"), "{text}");
    }
}
