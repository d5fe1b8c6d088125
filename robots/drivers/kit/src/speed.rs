//! The speed of something whose position is heard of now and then.

use core::time::Duration;

/// The speed of something whose position is heard of now and then, over at least 100 ms, because what a device tells has few digits.
///
/// ```
/// use core::time::Duration;
/// use mrroc_driver_kit::Speed;
///
/// let mut speed = Speed::from(Duration::ZERO, 3.0);
/// assert_eq!(speed.at(Duration::from_millis(99), 4.0), None);
/// assert_eq!(speed.at(Duration::from_millis(200), 4.0), Some(5.0));
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Speed {
    since: (Duration, f64),
}

impl Speed {
    const WINDOW: Duration = Duration::from_millis(100);

    /// The speed of something that stands at this position, at this time since the session's beginning.
    #[must_use]
    pub const fn from(now: Duration, position: f64) -> Speed {
        Speed { since: (now, position) }
    }

    /// Takes a position in: the speed since the last one, in units a second, where that was 100 ms ago or more.
    pub fn at(&mut self, now: Duration, position: f64) -> Option<f64> {
        let (since, before) = self.since;
        let time = now.saturating_sub(since);
        (time >= Speed::WINDOW).then(|| {
            self.since = (now, position);
            (position - before) / time.as_secs_f64()
        })
    }
}
