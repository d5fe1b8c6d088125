//! How an agent keeps its node's steps with those of the MP.
//!
//! In: pings that it sends, and their answers with the time of the MP's machine. Out: when the cell's time begins by the clock of
//! this machine, and by how much that has moved since.
//!
//! What counts for a robot is when orders arrive, not what a clock says. So a node's time is the time at which the other
//! machine's words of that time have arrived here, nine out of ten of them, and [`allowance`] later: clocks of both machines may
//! differ, and messages between them may take long. The newest arrivals count, and the node's time follows them slowly enough for
//! drives not to notice.

use core::time::Duration;

use hdrhistogram::Histogram;
use mrroc_core::link::Nanos;

/// How many arrivals count.
const ARRIVALS: usize = 64;

/// The share of them that is in time.
const IN_TIME: f64 = 0.9;

/// How often the node's time follows, and the most by which it moves at once \[ns\]: half a hundredth of the time.
pub(super) const FOLLOWS: Duration = Duration::from_millis(5);
const MOST: i64 = 25_000;

/// By how much a node's time is behind the arrival of words \[ns\], in a cell of this step. An order is later than a word of the network's
/// own: the MP, the carrier and the ECP work for it, some tenths of a millisecond. And one of ten words is late: in a longer step an
/// order that is late by a tenth of it misses none. Robots of the node are later by as much.
pub(super) fn allowance(step: Duration) -> i64 {
    let step = step.as_nanos() as Nanos;
    (step / 10).max(WORK.min(step / 4)).cast_signed()
}

/// What an ECP and the MP do for a step besides waiting \[ns\]: some tenths of a millisecond each.
pub(super) const WORK: Nanos = 500_000;

/// What is known of the time between two machines, and of their clocks.
#[derive(Debug)]
pub(super) struct Phase {
    /// Time here at an arrival, less the time there when it was sent \[ns\]; the newest ones, in a ring.
    lags: Vec<i64>,
    next: usize,
    /// The one that counts when the cell's time began.
    base: Option<i64>,
    /// By how much the node's time has moved since \[ns\].
    slew: i64,
    /// By how much the node's time is behind the arrival that counts \[ns\].
    allowance: i64,
    round_trips: Option<Histogram<u64>>,
    asked: u64,
    /// How far arrivals were from the one that counted \[ns\].
    jitter: Option<Histogram<u64>>,
}

/// What is told at the end of a run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Figures {
    /// Pings, and those that were not answered.
    pub asked: u64,
    pub lost: u64,
    /// Round trips: half, 99 %, 99.9 % of them took no longer \[ns\].
    pub round_trip: [Nanos; 3],
    /// How far 99 % of the arrivals were from where they were expected, at most \[ns\].
    pub jitter: Nanos,
    /// By how much the node's time has moved \[ns\].
    pub slew: i64,
}

impl Phase {
    /// Of the time to a node whose time is this much behind the arrival of words \[ns\].
    pub fn new(allowance: i64) -> Phase {
        let histogram = || Histogram::new_with_bounds(1, 60_000_000_000, 2).ok();
        Phase {
            lags: Vec::with_capacity(ARRIVALS),
            next: 0,
            base: None,
            slew: 0,
            allowance,
            round_trips: histogram(),
            asked: 0,
            jitter: histogram(),
        }
    }

    /// A ping is sent.
    pub const fn ask(&mut self) {
        self.asked += 1;
    }

    /// The answer to a ping of the time `sent` has come at the time `now`, both by the clock of this machine; the other one's said
    /// `answered`.
    pub fn hear(&mut self, sent: Nanos, answered: Nanos, now: Nanos) {
        let lag = now.wrapping_sub(answered).cast_signed();
        if let Some(histogram) = &mut self.round_trips {
            histogram.saturating_record(now.saturating_sub(sent).max(1));
        }
        if let (Some(base), Some(histogram)) = (self.base, &mut self.jitter) {
            histogram.saturating_record((lag - base - self.slew).unsigned_abs().max(1));
        }
        if self.lags.len() < ARRIVALS {
            self.lags.push(lag);
        } else {
            self.lags[self.next] = lag;
        }
        self.next = (self.next + 1) % ARRIVALS;
    }

    /// How many answers have come, [`ARRIVALS`] at most.
    pub const fn heard(&self) -> usize {
        self.lags.len()
    }

    /// The lag that so many arrivals keep.
    fn kept(&self) -> Option<i64> {
        let mut lags = self.lags.clone();
        lags.sort_unstable();
        lags.get((IN_TIME * lags.len() as f64) as usize).copied()
    }

    /// The cell's time begins at `origin` of the other machine's clock; returns when that is by the clock of this one. It is the
    /// same for all that ask.
    pub fn begin(&mut self, origin: Nanos) -> Option<Nanos> {
        let base = self.base.or_else(|| self.kept())?;
        self.base = Some(base);
        origin.checked_add_signed(base + self.allowance)
    }

    /// Follows the arrivals; returns by how much the node's time has moved since it began \[ns\].
    pub fn follow(&mut self) -> i64 {
        if let (Some(base), Some(kept)) = (self.base, self.kept()) {
            self.slew += (kept - base - self.slew).clamp(-MOST, MOST);
        }
        self.slew
    }

    /// What is told at the end.
    pub fn figures(&self) -> Figures {
        let of = |histogram: &Option<Histogram<u64>>, share| {
            histogram.as_ref().map_or(0, |histogram| histogram.value_at_quantile(share))
        };
        let heard = self.round_trips.as_ref().map_or(0, Histogram::len);
        Figures {
            asked: self.asked,
            lost: self.asked.saturating_sub(heard),
            round_trip: [0.5, 0.99, 0.999].map(|share| of(&self.round_trips, share)),
            jitter: of(&self.jitter, 0.99),
            slew: self.slew,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SECOND: u64 = 1_000_000_000;
    const ALLOWED: i64 = 400_000;

    /// Clocks that differ by an hour, and one of which goes faster by so many billionths; messages that take 300 us, and every twentieth
    /// time 5 ms more.
    fn run(billionths: u64, seconds: u64) -> (Phase, Nanos, i64) {
        let here = |there: Nanos| {
            there + 3600 * SECOND + there / SECOND * billionths + there % SECOND * billionths / SECOND
        };
        let mut phase = Phase::new(ALLOWED);
        let ping = |phase: &mut Phase, there: Nanos, i: u64| {
            let late = if i.is_multiple_of(20) { 5_000_000 } else { 0 };
            phase.ask();
            phase.hear(here(there - 300_000), there, here(there + 300_000 + late));
        };
        (0..50).for_each(|i| ping(&mut phase, SECOND + i * 10_000_000, i));
        let origin = phase.begin(2 * SECOND).expect("heard");
        let mut slew = 0;
        for i in 0..20 * seconds {
            ping(&mut phase, 2 * SECOND + i * 50_000_000, i);
            slew = phase.follow();
        }
        (phase, origin, slew)
    }

    #[test]
    fn a_nodes_time_begins_when_the_word_of_it_arrives_whatever_its_clock_says() {
        let (phase, origin, slew) = run(0, 10);
        assert_eq!(origin, 3600 * SECOND + 2 * SECOND + 700_000);
        assert_eq!(slew, 0);
        let figures = phase.figures();
        // Two digits of the histograms count.
        assert!((600_000..606_000).contains(&figures.round_trip[0]), "{figures:?}");
        assert!((5_600_000..5_660_000).contains(&figures.round_trip[1]), "{figures:?}");
        assert_eq!((figures.asked, figures.lost), (250, 0));
    }

    #[test]
    fn an_order_may_be_late_by_its_work_in_a_short_step_and_by_a_tenth_of_a_long_one() {
        let allowed = |milliseconds| allowance(Duration::from_millis(milliseconds));
        assert_eq!([1, 2, 4, 20].map(allowed), [250_000, 500_000, 500_000, 2_000_000]);
    }

    #[test]
    fn a_clock_that_goes_faster_is_followed_by_the_same() {
        // 50 millionths, over ten minutes: 30 ms, followed 20 times a second.
        let (_, _, slew) = run(50_000, 600);
        let expected = 600.0 * 50e-6;
        let error = slew as f64 * 1e-9 - expected;
        // 64 arrivals are 3.2 s, in which the clock goes on by 160 us.
        assert!(error.abs() < 200e-6, "{error}");
    }

    #[test]
    fn nine_arrivals_of_ten_are_in_time_however_late_they_are() {
        let mut phase = Phase::new(0);
        // As many microseconds late as there are numbers below 64, shuffled.
        for i in 0..64_u64 {
            phase.hear(0, 1_000_000, 1_000_000 + i * 29 % 64 * 1000);
        }
        let origin = phase.begin(0).expect("heard");
        let late = (0..64_u64).filter(|i| i * 1000 > origin).count();
        assert!((5..=7).contains(&late), "{late} of 64");
        // Later words of the same time are what the node's time then follows, by no more than that at once.
        for _ in 0..64 {
            phase.hear(0, 1_000_000, 1_500_000);
        }
        assert_eq!(phase.follow(), MOST);
        (0..100).for_each(|_| _ = phase.follow());
        assert_eq!(origin.checked_add_signed(phase.follow()), Some(500_000));
    }
}
