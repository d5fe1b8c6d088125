//! When the servo periods of a robot begin that counts them on a clock of its own.
//!
//! In: the times at which messages that begin a period came, each late by some jitter. Out: when the periods begin and how long
//! they are, on the cell's clock, without the jitter. It is the expanding-memory filter of the first degree (the line by least
//! squares through all that came, updated one by one) until it remembers [`MEMORY`] periods, and from then on forgets at
//! that rate: so it starts fast, and follows a clock that drifts.

use core::time::Duration;

use crate::model::pace::Pulse;
use crate::model::time::Nanos;

/// Periods that it remembers: of jitter of uniform distribution in 0.2 ms, 7 µs remain in the beginnings of periods.
const MEMORY: f64 = 256.0;

/// Periods that it pretends to remember at first, so that the jitter of the first messages does not become a rate.
const FIRST: f64 = 8.0;

/// By how much the length of a period may differ from the nominal one. Quartzes differ by a ten-thousandth, controllers that
/// are simulated on a busy machine by much more.
const RATE: f64 = 0.5;

/// Share of a period by which one message counts as late at most: more is a disturbance of the network and not of the clock.
const LATE: f64 = 0.25;

/// So many messages in a row that are farther away than a period are those of a clock that was set anew.
const STRANGE: u32 = 16;

/// Looks for a message in a period. The first is this share of a period after the message should be here, which leaves the
/// controller most of its period to take the answer.
const LOOKS: u64 = 8;

/// When a robot's periods begin.
pub(super) struct PhaseLock {
    /// The period as the driver declares it \[ns\].
    nominal: f64,
    /// The last period: its count, when it began \[ns\] and how long it is \[ns\], by the filter.
    last: Option<Last>,
    /// How many periods the filter remembers.
    memory: f64,
    /// Messages in a row that fit no period.
    strange: u32,
    /// When a message came last, or when listening began \[ns\].
    heard: Nanos,
    /// How long the robot may say nothing \[ns\].
    timeout: Nanos,
}

#[derive(Clone, Copy)]
struct Last {
    count: u64,
    began: f64,
    period: f64,
}

/// A servo period of the robot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Began {
    /// When it began, and when it ends \[ns\].
    pub at: Nanos,
    pub end: Nanos,
    /// Periods before it that have not been seen.
    pub lost: u64,
    /// How long ago its message came \[ns\].
    pub age: Nanos,
}

impl PhaseLock {
    /// Listens from `now` on for periods of a nominal length.
    pub fn new(now: Nanos, period: Duration, timeout: Duration) -> Self {
        PhaseLock {
            nominal: (period.as_nanos() as f64).max(1.0),
            last: None,
            memory: FIRST,
            strange: 0,
            heard: now,
            timeout: timeout.as_nanos() as Nanos,
        }
    }

    /// A message has come. `None` if it repeats one that has come before, is older, or counts periods for which there was no time yet.
    pub fn hear(&mut self, now: Nanos, pulse: Pulse) -> Option<Began> {
        let age = pulse.age.as_nanos() as Nanos;
        let arrival = now.saturating_sub(age);
        let Some(last) = self.last else { return Some(self.begin(pulse.count, arrival, age)) };
        // One whose count stands still is silent.
        if pulse.count == last.count {
            return None;
        }
        let periods = pulse.count.checked_sub(last.count);
        let passed = periods.unwrap_or(0) as f64;
        let expected = last.began + last.period * passed;
        let off = arrival as f64 - expected;
        let Some(periods) = periods.filter(|_| off >= -last.period) else {
            // A controller that was started anew counts from another beginning. A single such count is none: its robot would be told
            // where to be at a time that is still to come.
            self.strange += 1;
            return (self.strange >= STRANGE).then(|| self.begin(pulse.count, arrival, age));
        };
        if off > last.period {
            self.strange += 1;
            if self.strange >= STRANGE {
                return Some(self.begin(pulse.count, arrival, age));
            }
        } else {
            self.strange = 0;
        }
        let off = off.clamp(-LATE * last.period, LATE * last.period);
        let n = self.memory;
        self.memory = (n + 1.0).min(MEMORY);
        let gain = 2.0 * (2.0 * n + 1.0) / ((n + 1.0) * (n + 2.0));
        let rate_gain = 6.0 / ((n + 1.0) * (n + 2.0));
        let period = last.period + rate_gain * off / passed;
        let period = period.clamp((1.0 - RATE) * self.nominal, (1.0 + RATE) * self.nominal);
        // However late a message is: a period begins after the one before.
        let began = (expected + gain * off).max(last.began + 0.5 * last.period);
        self.heard = now;
        self.last = Some(Last { count: pulse.count, began, period });
        // It has begun: the demands that its end needs are known.
        let at = began.min(now as f64);
        Some(Began { at: at as Nanos, end: (at + period) as Nanos, lost: periods - 1, age })
    }

    /// The first message, or the first of a clock that was set anew.
    fn begin(&mut self, count: u64, arrival: Nanos, age: Nanos) -> Began {
        (self.memory, self.strange, self.heard) = (FIRST, 0, arrival + age);
        self.last = Some(Last { count, began: arrival as f64, period: self.nominal });
        Began { at: arrival, end: arrival + self.nominal as Nanos, lost: 0, age }
    }

    /// When to look for the next message, if none has come by `now` \[ns\].
    pub fn next_look(&self, now: Nanos) -> Nanos {
        let pause = (self.nominal as Nanos / LOOKS).max(1);
        let Some(last) = self.last else { return now + pause };
        // Later ones are due as well, once the next one has been missed.
        let first = ((last.began + last.period) as Nanos).saturating_add(pause);
        if first > now { first } else { now + pause }
    }

    /// For how long the robot has said nothing, if that is longer than it may be \[ns\].
    pub fn silent_for(&self, now: Nanos) -> Option<Nanos> {
        let silent = now.saturating_sub(self.heard);
        (silent > self.timeout).then_some(silent)
    }

    /// Listens anew from `now` on: after a reset.
    pub fn forget(&mut self, now: Nanos) {
        (self.last, self.memory, self.strange, self.heard) = (None, FIRST, 0, now);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: f64 = 1e6;

    /// A clock that differs by `rate` from the cell's, whose messages come with jitter of uniform distribution.
    struct Clock {
        period: f64,
        jitter: f64,
        random: u64,
    }

    impl Clock {
        fn new(rate: f64, jitter: f64) -> Clock {
            Clock { period: MS * (1.0 + rate), jitter, random: 88_172_645_463_325_252 }
        }

        fn begins(&self, count: u64) -> f64 {
            5e6 + self.period * count as f64
        }

        fn comes(&mut self, count: u64) -> Nanos {
            self.random ^= self.random << 13;
            self.random ^= self.random >> 7;
            self.random ^= self.random << 17;
            let share = (self.random >> 11) as f64 / (1_u64 << 53) as f64;
            (self.begins(count) + self.jitter * share) as Nanos
        }
    }

    fn lock() -> PhaseLock {
        PhaseLock::new(0, Duration::from_millis(1), Duration::from_millis(20))
    }

    fn hear(lock: &mut PhaseLock, came: Nanos, count: u64, age: Nanos) -> Option<Began> {
        lock.hear(came + age, Pulse { count, age: Duration::from_nanos(age) })
    }

    #[test]
    fn periods_begin_at_the_mean_of_the_jitter_at_the_rate_of_the_robots_clock() {
        for rate in [-2e-4, 0.0, 5e-5, 2e-4] {
            let mut clock = Clock::new(rate, 0.2 * MS);
            let mut lock = lock();
            let mut squares = 0.0;
            let (mut ends, mut now) = (None, 0);
            for count in 0..20_000 {
                let came = clock.comes(count);
                now = lock.next_look(now);
                while now < came {
                    now = lock.next_look(now);
                }
                let began = hear(&mut lock, came, count, now - came).expect("a new one");
                assert_eq!((began.lost, began.age), (0, now - came));
                assert!(began.at <= now, "it has begun");
                // Each period follows the one before: nothing is left out, nothing is twice.
                if let Some(end) = ends.replace(began.end) {
                    let gap = began.at as f64 - end as f64;
                    assert!(count < 2000 || gap.abs() < 0.01 * MS, "{count}: {gap} ns");
                }
                if count >= 10_000 {
                    let off = began.at as f64 - clock.begins(count) - 0.1 * MS;
                    squares += off * off / 10_000.0;
                }
            }
            // The variance of a line by least squares through n points, at its end: 4 / n of the jitter's 0.2²/12 ms².
            let expected = 0.2 * MS / 12.0_f64.sqrt() * (4.0 / MEMORY).sqrt();
            assert!(squares.sqrt() < 1.3 * expected, "{rate}: {} ns, {expected}", squares.sqrt());
            let period = lock.last.expect("locked").period;
            assert!((period / clock.period - 1.0).abs() < 3e-5, "{rate}: {period}");
        }
    }

    #[test]
    fn lost_messages_are_counted_and_one_that_is_very_late_moves_little() {
        let mut clock = Clock::new(1e-4, 0.0);
        let mut lock = lock();
        (0..1000).for_each(|count| _ = hear(&mut lock, clock.comes(count), count, 0));
        let began = hear(&mut lock, clock.comes(1019), 1019, 0).expect("a new one");
        assert_eq!(began.lost, 19);
        assert!((began.at as f64 - clock.begins(1019)).abs() < 100.0);
        // 0.9 of a period late: it counts as a quarter.
        let late = hear(&mut lock, clock.comes(1020) + 900_000, 1020, 0).expect("a new one");
        assert!((late.at as f64 - clock.begins(1020)).abs() < 0.25 * MS * 4.0 / MEMORY + 100.0);
        assert_eq!(hear(&mut lock, clock.comes(1020), 1020, 0), None);
        assert_eq!(hear(&mut lock, clock.comes(1010), 1010, 0), None);
    }

    #[test]
    fn a_controller_that_starts_anew_is_locked_to_anew() {
        let mut clock = Clock::new(0.0, 0.0);
        let mut lock = lock();
        (0..1000).for_each(|count| _ = hear(&mut lock, clock.comes(count), count, 0));
        // It counts from 0 again, at another phase.
        let heard = (0..100).map(|count| hear(&mut lock, clock.comes(3000 + count) + 400_000, count, 0));
        let heard: Vec<_> = heard.collect();
        assert!(heard[..STRANGE as usize - 1].iter().all(Option::is_none));
        let last = heard[99].expect("locked");
        assert!((last.at as f64 - clock.begins(3099) - 400_000.0).abs() < 1.0, "{last:?}");
    }

    #[test]
    fn fault_250_a_count_for_which_there_was_no_time_is_no_period_and_nothing_waits_for_it() {
        for jump in [2, 20, 300, 20_000, u64::MAX / 2, u64::MAX - 1001] {
            let mut clock = Clock::new(1e-4, 0.0);
            let mut lock = lock();
            (0..1000).for_each(|count| _ = hear(&mut lock, clock.comes(count), count, 0));
            let came = clock.comes(1000);
            assert_eq!(hear(&mut lock, came, 1000 + jump, 0), None, "{jump}");
            // The next look and the next message are as without it, and it counts as nothing that was heard.
            assert!(lock.next_look(came) <= came + 1_200_000, "{jump}");
            assert_eq!(lock.silent_for(clock.comes(999) + 20_000_001), Some(20_000_001));
            let began = hear(&mut lock, clock.comes(1001), 1001, 0).expect("a new one");
            assert!(
                (began.at as f64 - clock.begins(1001)).abs() < 100.0 && began.lost == 1,
                "{jump}: {began:?}"
            );
            // A clock that goes on from there was set anew.
            let heard = (2..100).map(|n| {
                hear(&mut lock, clock.comes(1000 + n), 1000_u64.wrapping_add(jump).wrapping_add(n), 0)
            });
            let heard: Vec<_> = heard.collect();
            assert!(heard[..STRANGE as usize - 1].iter().all(Option::is_none), "{jump}");
            assert!(heard[97].is_some(), "{jump}");
        }
    }

    #[test]
    fn fault_250_a_robot_whose_count_stands_still_is_silent() {
        let mut clock = Clock::new(0.0, 0.0);
        let mut lock = lock();
        (0..1000).for_each(|count| _ = hear(&mut lock, clock.comes(count), count, 0));
        assert!((1000..1100).all(|n| hear(&mut lock, clock.comes(n), 999, 0).is_none()));
        assert_eq!(lock.silent_for(clock.comes(1100)), Some(clock.comes(1100) - clock.comes(999)));
    }

    #[test]
    fn it_looks_for_a_message_when_it_should_be_there_and_then_again_until_it_is_silent_for_too_long() {
        let mut lock = lock();
        assert_eq!(lock.next_look(0), 125_000);
        hear(&mut lock, 1_000_000, 7, 0);
        assert_eq!(lock.next_look(1_000_000), 2_125_000);
        assert_eq!(lock.next_look(2_125_000), 2_250_000);
        assert_eq!(lock.silent_for(21_000_000), None);
        assert_eq!(lock.silent_for(21_000_001), Some(20_000_001));
        lock.forget(30_000_000);
        assert_eq!(lock.silent_for(50_000_000), None);
    }
}
