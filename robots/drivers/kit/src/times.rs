//! When the newest reading came, and when something was asked for, as a session and the drives see it.
//!
//! In and out: times since the session's beginning, by the clock of whoever asks. Nothing here reads a clock.

use core::sync::atomic::{AtomicU64, Ordering};
use core::time::Duration;

/// How long something goes on that is asked for no more.
const ASKED: Duration = Duration::from_millis(100);

/// When a session has heard the newest reading, and when the drives have asked for something last.
///
/// ```
/// use core::time::Duration;
/// use mrroc_driver_kit::Times;
///
/// let times = Times::default();
/// let at = Duration::from_millis;
/// assert!(!times.has_heard() && !times.is_asked(at(10)));
/// times.hear(at(10));
/// assert!(times.has_heard() && !times.is_silent_for(at(60), at(50)) && times.is_silent_for(at(61), at(50)));
/// times.ask(at(20));
/// assert!(times.is_asked(at(120)) && !times.is_asked(at(121)));
/// ```
#[derive(Debug, Default)]
pub struct Times {
    /// Since the session's beginning \[ns\], and 1 more; 0: never.
    asked: AtomicU64,
    heard: AtomicU64,
}

impl Times {
    /// Asks now for what may go on only while it is asked for, such as a homing.
    pub fn ask(&self, now: Duration) {
        self.asked.store(word(now), Ordering::Release);
    }

    /// Whether something is asked for: within the last 100 ms.
    #[must_use]
    pub fn is_asked(&self, now: Duration) -> bool {
        let asked = self.asked.load(Ordering::Acquire);
        asked != 0 && !is_older(asked, now, ASKED)
    }

    /// A reading came now, and has been handed over before.
    pub fn hear(&self, now: Duration) {
        self.heard.store(word(now), Ordering::Release);
    }

    /// Whether a reading has come: then what was handed over before it is seen.
    #[must_use]
    pub fn has_heard(&self) -> bool {
        self.heard.load(Ordering::Acquire) != 0
    }

    /// Whether the newest reading, or the session's beginning where none has come, is longer ago than this.
    #[must_use]
    pub fn is_silent_for(&self, now: Duration, time: Duration) -> bool {
        is_older(self.heard.load(Ordering::Acquire), now, time)
    }
}

/// A time as a word that is not 0.
fn word(now: Duration) -> u64 {
    now.as_nanos() as u64 + 1
}

/// Whether that, or the beginning where it never was, is longer ago.
fn is_older(when: u64, now: Duration, than: Duration) -> bool {
    Duration::from_nanos(word(now).saturating_sub(when.max(1))) > than
}
