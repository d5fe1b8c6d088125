//! Corrections of the axes: what has been demanded, and what an answer says of it.
//!
//! In: how far each axis shall be from where it was when the interface was switched on, and what the controller says about
//! its last answers. Out: the correction for the next answer.
//!
//! All is counted in whole millionths of a degree, which is what an answer has, so that no rounding is left behind. With
//! relative corrections the controller adds up what it takes, and an answer that it does not take moves nothing. It counts these
//! (`Delay`), so the driver knows what was lost, and a later answer contains it.

use crate::message::AXES;

/// Millionths of a degree.
const PARTS: f64 = 1e6;

/// What a controller counts corrections from, which its program says when it switches the interface on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Corrections {
    /// From where the axes were then: `RSI_ON(#ABSOLUTE)`. An answer that is lost is made good by the next one.
    Absolute,
    /// From the correction before: `RSI_ON(#RELATIVE)`. The controller sends `DEF_Delay`, and `HOLDON` of its `AKorr` is 0: with 1
    /// it takes the last correction again wherever an answer is missing.
    Relative,
}

/// Periods that are remembered: more answers in a row that are not taken are told as a fault.
const REMEMBERED: usize = 128;

/// When a controller counts a late answer, which is found out when the drives are opened.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Counts {
    /// In the next message.
    AtOnce,
    /// When it has taken a later answer, in the message after that.
    Later,
}

/// Corrections so far, in millionths of a degree.
#[derive(Clone, Debug)]
pub(crate) struct Sum {
    corrections: Corrections,
    counts: Counts,
    /// What is demanded, against the start.
    demanded: [i64; AXES],
    /// What the controller has added up, if it took all of which it has not told otherwise.
    taken: [i64; AXES],
    /// What was added in the last periods, at the places of their numbers.
    added: [(u64, [i64; AXES]); REMEMBERED],
    /// The period of the controller's last message, and the answers that it had not taken until then.
    period: u64,
    late: u64,
    /// The last period that was answered.
    answered: u64,
}

impl Sum {
    pub(crate) const fn new(corrections: Corrections, counts: Counts) -> Sum {
        Sum {
            corrections,
            counts,
            demanded: [0; AXES],
            taken: [0; AXES],
            added: [(0, [0; AXES]); REMEMBERED],
            period: 0,
            late: 0,
            answered: 0,
        }
    }

    /// The interface was switched on anew, and has said this.
    pub(crate) fn clear(&mut self, period: u64, late: u64) {
        *self = Sum { period, late, ..Sum::new(self.corrections, self.counts) };
    }

    /// Each axis shall be so far from the start \[deg\].
    pub(crate) fn demand(&mut self, offsets: &[f64; AXES]) {
        // No axis has the 9e12 degrees at which this would saturate.
        self.demanded = offsets.map(|offset| (offset * PARTS).round() as i64);
    }

    /// A message of the controller has come, of this period, and says how many answers were late so far, or in a row. Those that are
    /// new belong to the last periods before this one, or before the one that was answered last; what was not answered is
    /// among them, and has added nothing.
    pub(crate) fn settle(&mut self, period: u64, late: u64) {
        let new = late.checked_sub(self.late).unwrap_or(late);
        let before = match self.counts {
            Counts::AtOnce => period,
            Counts::Later => self.answered,
        };
        for lost in before.saturating_sub(new.min(REMEMBERED as u64))..before {
            let (of, added) = &mut self.added[lost as usize % REMEMBERED];
            if *of == lost {
                // Once: of those in a row it may be told again.
                for (taken, added) in self.taken.iter_mut().zip(core::mem::take(added)) {
                    *taken -= added;
                }
            }
        }
        (self.period, self.late) = (period, late);
    }

    /// The corrections for the answer to the last message \[deg\], in whole millionths.
    pub(crate) fn next(&mut self) -> [f64; AXES] {
        let told = match self.corrections {
            Corrections::Absolute => self.demanded,
            Corrections::Relative => {
                let place = &mut self.added[self.period as usize % REMEMBERED];
                // The same message may have come twice.
                let mut added = if place.0 == self.period { place.1 } else { [0; AXES] };
                for ((added, demanded), taken) in added.iter_mut().zip(self.demanded).zip(self.taken) {
                    *added += demanded - taken;
                }
                *place = (self.period, added);
                self.answered = self.period;
                self.taken = self.demanded;
                added
            }
        };
        told.map(|parts| parts as f64 / PARTS)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A generator of Lehmer's, by which each run loses the same.
    struct Seeded(u64);

    impl Seeded {
        fn one_in(&mut self, n: u64) -> bool {
            self.0 = self.0 * 48_271 % 0x7fff_ffff;
            self.0.is_multiple_of(n)
        }
    }

    /// How a controller counts what is late.
    #[derive(Clone, Copy, Debug, PartialEq)]
    enum Delay {
        /// All that ever were.
        All,
        /// Those since the last one that was in time.
        InARow,
        /// All, when the next answer has come, as RSIPI's emulator does.
        WhenHeard,
    }

    /// A controller that adds up what it takes, as text with six decimals: what `ToController` writes.
    struct Controller {
        axes: [i64; AXES],
        late: u64,
        uncounted: u64,
        delay: Delay,
    }

    impl Controller {
        fn takes(&mut self, answer: Option<[f64; AXES]>) {
            match (answer, self.delay) {
                (None, Delay::WhenHeard) => self.uncounted += 1,
                (None, Delay::All | Delay::InARow) => self.late += 1,
                (Some(told), delay) => {
                    for (axis, told) in self.axes.iter_mut().zip(told) {
                        let text = format!("{told:.6}").replace('.', "");
                        *axis += text.parse::<i64>().expect("a number of millionths");
                    }
                    self.late += core::mem::take(&mut self.uncounted);
                    if delay == Delay::InARow {
                        self.late = 0;
                    }
                }
            }
        }
    }

    #[test]
    fn relative_corrections_add_up_to_what_is_demanded_in_100_000_periods_in_which_packets_are_lost() {
        for delay in [Delay::All, Delay::InARow, Delay::WhenHeard] {
            let mut lost = Seeded(20_261_123);
            let mut controller = Controller { axes: [0; AXES], late: 0, uncounted: 0, delay };
            let counts = if delay == Delay::WhenHeard { Counts::Later } else { Counts::AtOnce };
            let mut sum = Sum::new(Corrections::Relative, counts);
            let (mut missed, mut in_time) = (0, 0);
            let mut exact = [0; AXES];
            for period in 1..=100_000_u64 {
                // What the controller says is lost, or the answer to it, or several in a row; in between nothing for a while.
                let clear = period % 1000 > 900;
                if !clear && (lost.one_in(50) || period % 997 < 5) {
                    (missed, in_time) = (missed + 1, 0);
                    controller.takes(None);
                    continue;
                }
                sum.settle(period, controller.late);
                let t = period as f64 * 4e-3;
                let offsets = core::array::from_fn(|i| 40.0 * f64::sin(t * (0.3 + 0.1 * i as f64)));
                sum.demand(&offsets);
                let answer = sum.next();
                if !clear && (lost.one_in(50) || period % 1009 < 3) {
                    (missed, in_time) = (missed + 1, 0);
                    controller.takes(None);
                    continue;
                }
                controller.takes(Some(answer));
                in_time += 1;
                exact = offsets.map(|offset| (offset * PARTS).round() as i64);
                // What was lost is in the next answer, or in the one after that.
                let known = if counts == Counts::AtOnce { 1 } else { 3 };
                if in_time >= known {
                    assert_eq!(controller.axes, exact, "period {period}, late {delay:?}");
                }
            }
            assert_eq!(controller.axes, exact);
            assert!(missed > 4000, "{missed}");
        }
    }

    #[test]
    fn absolute_corrections_are_what_is_demanded_whatever_was_lost() {
        let mut sum = Sum::new(Corrections::Absolute, Counts::AtOnce);
        sum.demand(&[1.5, -0.000_000_4, 0.0, 0.0, 0.0, -170.123_456_7]);
        assert_eq!(sum.next(), [1.5, 0.0, 0.0, 0.0, 0.0, -170.123_457]);
        sum.settle(1, 1);
        assert_eq!(sum.next(), [1.5, 0.0, 0.0, 0.0, 0.0, -170.123_457]);
    }

    #[test]
    fn what_stands_still_is_told_to_stay_and_a_new_start_forgets() {
        let mut sum = Sum::new(Corrections::Relative, Counts::AtOnce);
        sum.settle(1, 0);
        sum.demand(&[2.0; AXES]);
        assert_eq!(sum.next(), [2.0; AXES]);
        assert_eq!(sum.next(), [2.0; AXES], "the same message once more has the same answer");
        sum.settle(2, 0);
        assert_eq!(sum.next(), [0.0; AXES]);
        sum.clear(3, 0);
        assert_eq!(sum.next(), [0.0; AXES]);
        sum.demand(&[2.0; AXES]);
        assert_eq!(sum.next(), [2.0; AXES]);
    }
}
