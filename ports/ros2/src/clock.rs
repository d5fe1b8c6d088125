//! The cell's time as ROS time.

use std::time::{SystemTime, UNIX_EPOCH};

use mrroc_external::monotonic;

/// When the cell's time was zero, by the wall clock.
///
/// It is found once in a run: a wall clock that is set while the cell runs changes no stamp, so stamps of one run are as far apart as its steps.
#[derive(Clone, Copy, Debug, Default)]
pub struct CellClock {
    /// By the wall clock, and by the machine's monotonic clock \[ns\].
    zero: Option<[u64; 2]>,
}

impl CellClock {
    /// Of one run, whose time was zero at this date \[ns since 1970\]: what is told at the times of the cell themselves.
    pub const fn since(date: u64) -> CellClock {
        CellClock { zero: Some([date, 0]) }
    }

    /// The date of a time of the cell \[ns\] that was told at `sent` by the machine's monotonic clock \[ns\]: \[ns since 1970\].
    pub fn date(&mut self, time: u64, sent: u64) -> u64 {
        self.date_at(time, sent, || [monotonic(), now()])
    }

    /// The same with what both clocks of the machine say \[ns\], which is asked for at the first step of a run alone.
    fn date_at(&mut self, time: u64, sent: u64, clocks: impl FnOnce() -> [u64; 2]) -> u64 {
        let began = sent.saturating_sub(time);
        let [zero, _] = match self.zero.filter(|[_, known]| !is_another_run(began, *known)) {
            Some(known) => known,
            None => {
                let [monotonic, wall] = clocks();
                let age = monotonic.saturating_sub(sent);
                *self.zero.insert([wall.saturating_sub(age).saturating_sub(time), began])
            }
        };
        zero + time
    }
}

/// A time that was zero so much earlier or later is that of another run \[ns\]: within a run that is how late a message may be told, and how late steps
/// may have become.
const ANOTHER: u64 = 1_000_000_000;

/// Whether the cell's time was zero in another run than the known one, both by the machine's monotonic clock \[ns\].
pub const fn is_another_run(zero: u64, known: u64) -> bool {
    zero.abs_diff(known) >= ANOTHER
}

/// Now, by the wall clock \[ns since 1970\].
pub fn now() -> u64 {
    let since = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    since.as_nanos() as u64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stamps_are_as_far_apart_as_the_times_of_the_cell_whenever_they_are_told() {
        let mut clock = CellClock::default();
        let sent = monotonic();
        let first = clock.date(5_000_000, sent);
        // Told late, and out of order by another robot.
        let second = clock.date(7_000_000, sent + 900_000_000);
        let third = clock.date(6_000_000, sent);
        assert_eq!((second - first, third - first), (2_000_000, 1_000_000));
    }

    #[test]
    fn fault_261_a_wall_clock_that_is_set_changes_no_stamp_of_a_run() {
        const HOUR: u64 = 3_600_000_000_000;
        const TODAY: u64 = 1_700_000_000_000_000_000;
        let mut clock = CellClock::default();
        for step in 0..1000_u64 {
            let (time, told) = (2_000_000 * step, 5_000_000_000 + 2_000_000 * step);
            // In step 300 the clock is set back by an hour, in step 600 on by three.
            let wall =
                TODAY + told + if step < 300 { HOUR } else { 0 } + if step < 600 { 0 } else { 3 * HOUR };
            let date = clock.date_at(time, told, || [told + 1_000_000, wall + 1_000_000]);
            assert_eq!(date, TODAY + HOUR + 5_000_000_000 + time, "step {step}");
        }
    }

    #[test]
    fn another_run_of_the_cell_begins_at_the_wall_clock_again_however_short_the_one_before_was() {
        let mut clock = CellClock::default();
        let sent = monotonic();
        // The run before began ten minutes ago, and ended within its first second.
        let before = clock.date(800_000_000, sent - 600_000_000_000);
        let after = clock.date(0, sent);
        let apart = after - before;
        assert!((599_000_000_000..601_000_000_000).contains(&apart), "{apart} ns");
    }
}
