//! The cell's time as ROS time.

use std::time::{SystemTime, UNIX_EPOCH};

use rustix::time::{ClockId, clock_gettime};

use crate::messages::Stamp;

/// When the cell's time was zero, by the wall clock.
///
/// It is found once: a wall clock that is set while the cell runs changes no stamp, so stamps of one run are as far apart as its steps.
#[derive(Clone, Copy, Debug, Default)]
pub struct CellClock {
    zero: Option<u64>,
    last: u64,
}

impl CellClock {
    /// The stamp of a time of the cell \[ns\] that was told at `sent` by the machine's monotonic clock \[ns\].
    pub fn stamp(&mut self, time: u64, sent: u64) -> Stamp {
        // Another run of the cell begins at zero again.
        if time + JUMP < self.last {
            *self = CellClock::default();
        }
        self.last = self.last.max(time);
        let zero = *self.zero.get_or_insert_with(|| {
            let age = monotonic().saturating_sub(sent);
            now().saturating_sub(age).saturating_sub(time)
        });
        Stamp::of(zero + time)
    }
}

/// Messages of several robots come by so much out of order at most \[ns\].
const JUMP: u64 = 1_000_000_000;

/// Now, by the wall clock \[ns since 1970\].
pub fn now() -> u64 {
    let since = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    since.as_nanos() as u64
}

fn monotonic() -> u64 {
    let now = clock_gettime(ClockId::Monotonic);
    (now.tv_sec * 1_000_000_000 + now.tv_nsec).cast_unsigned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stamps_are_as_far_apart_as_the_times_of_the_cell_whenever_they_are_told() {
        let mut clock = CellClock::default();
        let sent = monotonic();
        let nanos = |stamp: Stamp| i64::from(stamp.sec) * 1_000_000_000 + i64::from(stamp.nanosec);
        let first = nanos(clock.stamp(5_000_000, sent));
        // Told late, and out of order by another robot.
        let second = nanos(clock.stamp(7_000_000, sent + 900_000_000));
        let third = nanos(clock.stamp(6_000_000, sent));
        assert_eq!((second - first, third - first), (2_000_000, 1_000_000));
    }

    #[test]
    fn another_run_of_the_cell_begins_at_the_wall_clock_again() {
        let mut clock = CellClock::default();
        let before = clock.stamp(3_600_000_000_000, monotonic());
        let after = clock.stamp(0, monotonic());
        assert!(after >= before && after.sec - before.sec < 60, "{before:?}, {after:?}");
    }
}
