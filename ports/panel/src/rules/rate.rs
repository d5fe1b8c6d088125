//! How often a page may speak.
//!
//! In: when its messages come. Out: whether one is too many. A page of this panel sends some ten a second.

use core::time::Duration;

/// Messages that may come at once.
const BURST: f64 = 60.0;

/// Messages a second that may come for ever.
const PER_SECOND: f64 = 60.0;

/// What a page may still say.
#[derive(Clone, Copy, Debug)]
pub struct Rate {
    left: f64,
    at: Duration,
}

impl Rate {
    /// Of a page that connects at a time of a clock that only goes forward.
    #[must_use]
    pub const fn begin(now: Duration) -> Rate {
        Rate { left: BURST, at: now }
    }

    /// Counts a message that comes at a time; whether it may.
    pub fn may(&mut self, now: Duration) -> bool {
        let since = now.saturating_sub(self.at).as_secs_f64();
        self.left = (self.left + PER_SECOND * since).min(BURST);
        self.at = now;
        let may = self.left >= 1.0;
        if may {
            self.left -= 1.0;
        }
        may
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fault_203_of_a_flood_of_messages_no_more_than_sixty_a_second_are_taken() {
        let mut rate = Rate::begin(Duration::ZERO);
        // 10,000 a second for ten seconds: the burst, and sixty for each second after it.
        let taken = (0..100_000_u64).filter(|i| rate.may(Duration::from_micros(100 * i))).count();
        assert!((600..=660).contains(&taken), "{taken}");
        // One that speaks as a page does is never refused.
        let mut rate = Rate::begin(Duration::ZERO);
        assert!((0..10_000_u64).all(|i| rate.may(Duration::from_millis(25 * i))));
    }
}
