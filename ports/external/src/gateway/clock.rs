//! When something was on this machine's clock that a program on another one has timed by its own.
//!
//! In: times at which something was sent here, and came there. Out: a time of there as one of here, and never one that is
//! later than it was: what was sent here at `s` and came there at `r` says that `r` there was `s` here or later, so
//! `s - r` is a lower bound of the difference of the clocks. The largest of the last seconds is used: the one that was
//! in transit for the shortest time. So a reading counts as older than it is by that time, and no clock need agree with another.

/// How long a bound is used at most twice \[ns\]: clocks drift by 0.2 ms in a second at the very most, and mostly by a hundredth of that.
const WINDOW: u64 = 5_000_000_000;

/// The clock of another machine.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Clock {
    /// The largest difference here - there of this window, and that of the window before \[ns\].
    bounds: [Option<i128>; 2],
    /// When this window began.
    began: u64,
}

impl Clock {
    /// Hears, at a time `now`, that what was sent here came there.
    pub fn heard(&mut self, sent: u64, came: u64, now: u64) {
        if now.saturating_sub(self.began) > WINDOW {
            // After a long silence clocks may have drifted by more than an old bound allows for.
            let is_recent = now.saturating_sub(self.began) <= 2 * WINDOW;
            self.bounds = [None, self.bounds[0].filter(|_| is_recent)];
            self.began = now;
        }
        self.bounds[0] = self.bounds[0].max(Some(i128::from(sent) - i128::from(came)));
    }

    /// When that was which was at a time of there; `None` if nothing has been heard.
    pub fn here(&self, there: u64) -> Option<u64> {
        let ahead = self.bounds[0].max(self.bounds[1])?;
        let here = i128::from(there) + ahead;
        Some(u64::try_from(here.max(0)).unwrap_or(u64::MAX))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: u64 = 1_000_000;

    #[test]
    fn fault_212_a_time_of_another_machine_is_never_later_than_it_was_and_earlier_by_the_shortest_transit() {
        // There it is 7 s later, or 7 s earlier; messages take 1 to 9 ms.
        for offset in [7_000 * MS, 0, (-7_000_i64 * MS as i64).cast_unsigned()] {
            let there = |here: u64| here.wrapping_add(offset);
            let mut clock = Clock::default();
            assert_eq!(clock.here(5), None);
            for i in 0..1000 {
                let sent = 60_000 * MS + i * 4 * MS;
                let transit = (1 + (i * 5) % 9) * MS;
                clock.heard(sent, there(sent + transit), sent + 2 * transit);
                let measured = sent + 3 * MS;
                let told = clock.here(there(measured)).expect("something was heard");
                assert!(told <= measured, "a reading of the future");
                assert!(i < 9 || told == measured - MS, "{}", measured - told);
            }
        }
    }

    #[test]
    fn a_clock_that_stood_still_or_drifts_is_followed() {
        let mut clock = Clock::default();
        clock.heard(10_000 * MS, 10_001 * MS, 10_002 * MS);
        // Asleep for a second: its clock is behind from now on, which the next message tells.
        clock.heard(20_000 * MS, 19_001 * MS, 20_002 * MS);
        assert_eq!(clock.here(19_001 * MS), Some(20_000 * MS));
        // It was this machine that slept: what is too large is forgotten after two windows.
        for i in 0..3000 {
            let now = 30_000 * MS + i * 4 * MS;
            clock.heard(now, now + 5_001 * MS, now + 2 * MS);
        }
        assert_eq!(clock.here(60_001 * MS), Some(55_000 * MS));
    }

    #[test]
    fn fault_212_a_bound_of_before_a_long_silence_makes_no_reading_newer_than_it_is() {
        let mut clock = Clock::default();
        clock.heard(10_000 * MS, 10_001 * MS, 10_002 * MS);
        // An hour later the other clock is ahead by 180 ms: 50 ppm.
        let later = 3_610_000 * MS;
        clock.heard(later, later + 181 * MS, later + 2 * MS);
        assert_eq!(clock.here(later + 180 * MS), Some(later - MS));
    }

    #[test]
    fn fault_121_times_at_the_ends_of_their_range_are_times() {
        let mut clock = Clock::default();
        clock.heard(u64::MAX, 0, 0);
        assert_eq!(clock.here(u64::MAX), Some(u64::MAX));
        let mut clock = Clock::default();
        clock.heard(0, u64::MAX, 0);
        assert_eq!(clock.here(0), Some(0));
    }
}
