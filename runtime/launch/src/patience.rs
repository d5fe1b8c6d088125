//! The notes to whoever waits for a run that may have no end.
//!
//! In: the steps of a run and the wall clock. Out: a note, ever more seldom.

#![expect(clippy::disallowed_methods, reason = "it tells a user how long a run has taken")]

use std::time::{Duration, Instant};

use super::outcome::note;
use mrroc_core::operator::Operator;

/// Whoever waits for a run that may have no end is told of it, ever more seldom.
pub struct Patience {
    since: Instant,
    next: Duration,
}

impl Patience {
    pub fn new() -> Patience {
        Patience { since: Instant::now(), next: Duration::from_secs(10) }
    }

    /// A hook that looks at the wall clock now and then.
    pub fn notes(mut self) -> impl FnMut(u64, &Operator) {
        move |step, _| {
            if step % 1024 == 0
                && let Some(text) = self.after(self.since.elapsed(), step)
            {
                note(&text);
            }
        }
    }

    /// What is said of a run that is in this step after so much time, if anything.
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
        let mut patience = Patience::new();
        let told: Vec<_> = (0..100)
            .filter(|&second| patience.after(Duration::from_secs(second), second * 500).is_some())
            .collect();
        assert_eq!(told, [10, 20, 40, 80]);
        let text = patience.after(Duration::from_secs(160), 80_000).expect("160 s is twice 80 s");
        assert!(text.contains("160 s, in step 80000") && text.contains("`Step::Done`"), "{text}");
    }
}
