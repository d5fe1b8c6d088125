//! Numbers over the steps of a run, in bounded memory.
//!
//! In: numbers that belong together, such as those of one reading, of the steps in which there were some. Out: the same in order
//! of time, with gaps if wanted where a step has none. When there are too many, the numbers of 2, 4, 8 .. steps become one
//! stretch, of which the first, the last, the least and the greatest are kept, so that no peak is lost, however long the run
//! is.
//!
//! Several processes may show numbers of the same steps, in any order: what comes out depends on what was shown alone. Each
//! stretch begins at a multiple of its length, and what is kept of two sets of numbers follows from what is kept of each.

use core::cmp::Ordering;

use crate::states::States;
use crate::svg::Range;

/// The most stretches kept.
pub(crate) const CAPACITY: usize = 4000;

/// A number in a step, at a time \[s\].
#[derive(Clone, Copy, Debug)]
struct Sample {
    step: u64,
    time: f64,
    value: f64,
}

impl Sample {
    fn in_time(&self, other: &Sample) -> Ordering {
        let steps = self.step.cmp(&other.step).then(self.time.total_cmp(&other.time));
        steps.then(self.value.total_cmp(&other.value))
    }

    /// By value; of equal ones the earlier is the lesser.
    fn in_value(&self, other: &Sample) -> Ordering {
        self.value.total_cmp(&other.value).then(self.in_time(other))
    }
}

/// One number in a stretch.
#[derive(Clone, Copy, Debug)]
struct Extremes {
    first: Sample,
    last: Sample,
    least: Sample,
    greatest: Sample,
}

impl Extremes {
    /// Nothing of what is not finite.
    fn of(step: u64, time: f64, value: f64) -> Option<Extremes> {
        let sample = Sample { step, time, value };
        let extremes = Extremes { first: sample, last: sample, least: sample, greatest: sample };
        value.is_finite().then_some(extremes)
    }

    fn and(self, other: Extremes) -> Extremes {
        let pick = |a: Sample, b: Sample, is_b: bool| if is_b { b } else { a };
        let earlier = other.first.in_time(&self.first).is_lt();
        let later = other.last.in_time(&self.last).is_gt();
        let less = other.least.in_value(&self.least).is_lt();
        let greater = other.greatest.in_value(&self.greatest).is_gt();
        Extremes {
            first: pick(self.first, other.first, earlier),
            last: pick(self.last, other.last, later),
            least: pick(self.least, other.least, less),
            greatest: pick(self.greatest, other.greatest, greater),
        }
    }

    /// The least and the greatest in order of time.
    fn ends(&self) -> [f64; 2] {
        if self.greatest.in_time(&self.least).is_lt() {
            [self.greatest.value, self.least.value]
        } else {
            [self.least.value, self.greatest.value]
        }
    }

    /// All that is kept of it, in order of time.
    fn samples(&self) -> [Sample; 4] {
        let mut samples = [self.first, self.least, self.greatest, self.last];
        samples.sort_by(Sample::in_time);
        samples
    }
}

/// A step, and a time in it \[s\].
#[derive(Clone, Copy, Debug, PartialEq)]
struct Moment {
    step: u64,
    time: f64,
}

impl Moment {
    fn is_before(&self, other: &Moment) -> bool {
        self.step.cmp(&other.step).then(self.time.total_cmp(&other.time)).is_lt()
    }
}

/// Neighbours in time.
#[derive(Clone, Debug)]
struct Stretch {
    first: Moment,
    last: Moment,
    channels: Vec<Option<Extremes>>,
}

impl Stretch {
    fn extend(&mut self, other: &Stretch) {
        if other.first.is_before(&self.first) {
            self.first = other.first;
        }
        if self.last.is_before(&other.last) {
            self.last = other.last;
        }
        for (extremes, other) in self.channels.iter_mut().zip(&other.channels) {
            *extremes = match (*extremes, *other) {
                (Some(extremes), Some(other)) => Some(extremes.and(other)),
                (extremes, other) => extremes.or(other),
            };
        }
    }

    fn channel(&self, index: usize) -> Option<&Extremes> {
        self.channels.get(index)?.as_ref()
    }
}

/// Numbers over the steps of a run.
#[derive(Clone, Debug, Default)]
pub(crate) struct Track {
    /// In order of time, one for all steps with the same quotient by the length of a stretch.
    stretches: Vec<Stretch>,
    /// The length of a stretch is 2 to the power of this \[steps\].
    doublings: u32,
    has_gaps: bool,
}

/// What is drawn of a track.
pub(crate) struct Lines {
    /// When \[s\]; not a number at a gap.
    pub times: Vec<f64>,
    /// Of each number; not a number at a gap.
    pub values: Vec<Vec<f64>>,
}

impl Track {
    /// Of numbers that there are not between two steps which are no neighbours.
    pub fn with_gaps() -> Track {
        Track { has_gaps: true, ..Track::default() }
    }

    /// Numbers of a step, seen at a time \[s\], as many as before; what is not finite counts as none.
    pub fn see(&mut self, step: u64, time: f64, values: &[f64]) {
        if !time.is_finite() {
            return;
        }
        let moment = Moment { step, time };
        let channels = values.iter().map(|value| Extremes::of(step, time, *value)).collect();
        let next = Stretch { first: moment, last: moment, channels };
        let quotient = |stretch: &Stretch| stretch.first.step >> self.doublings;
        let place = match self.stretches.last() {
            Some(last) if quotient(last) >= quotient(&next) => {
                self.stretches.partition_point(|known| quotient(known) < quotient(&next))
            }
            _ => self.stretches.len(),
        };
        match self.stretches.get(place).map(|known| quotient(known) == quotient(&next)) {
            Some(true) => self.stretches[place].extend(&next),
            Some(false) | None => self.stretches.insert(place, next),
        }
        while self.stretches.len() > CAPACITY {
            self.doublings += 1;
            self.join();
        }
    }

    /// Whether there were never any numbers.
    pub fn is_empty(&self) -> bool {
        self.stretches.is_empty()
    }

    /// Makes one stretch of those that have become one.
    fn join(&mut self) {
        let mut joined: Vec<Stretch> = Vec::with_capacity(self.stretches.len());
        for stretch in self.stretches.drain(..) {
            let same = |last: &&mut Stretch| {
                last.first.step >> self.doublings == stretch.first.step >> self.doublings
            };
            match joined.last_mut().filter(same) {
                Some(last) => last.extend(&stretch),
                None => joined.push(stretch),
            }
        }
        self.stretches = joined;
    }

    /// The stretches in order of time, each with whether there is a gap before it.
    fn pieces(&self) -> impl Iterator<Item = (bool, &Stretch)> {
        let before = [None].into_iter().chain(self.stretches.iter().map(Some));
        before.zip(&self.stretches).map(|(before, stretch)| {
            let follows = before.is_none_or(|before| stretch.first.step <= before.last.step + 1);
            (self.has_gaps && !follows, stretch)
        })
    }

    /// The least and the greatest of number `index`, from 0; nothing where there was none.
    pub fn range(&self, index: usize) -> Option<Range> {
        let channels = self.stretches.iter().filter_map(|stretch| stretch.channel(index));
        let range = channels.fold(Range::NOTHING, |range, extremes| Range {
            low: range.low.min(extremes.least.value),
            high: range.high.max(extremes.greatest.value),
        });
        (range.low <= range.high).then_some(range)
    }

    /// The last of number `index`, from 0.
    pub fn last(&self, index: usize) -> Option<f64> {
        self.stretches.last()?.channel(index).map(|extremes| extremes.last.value)
    }

    /// The numbers at these places, from 0, in order of time.
    pub fn lines(&self, places: &[usize]) -> Lines {
        let mut lines = Lines { times: Vec::new(), values: vec![Vec::new(); places.len()] };
        let mut latest = f64::NEG_INFINITY;
        for (after_gap, stretch) in self.pieces() {
            if after_gap {
                lines.times.push(f64::NAN);
                lines.values.iter_mut().for_each(|values| values.push(f64::NAN));
            }
            let several = stretch.first != stretch.last;
            for moment in [Some(stretch.first), several.then_some(stretch.last)].into_iter().flatten() {
                // One process may see a step later than another one sees the next.
                latest = latest.max(moment.time);
                lines.times.push(latest);
            }
            for (values, place) in lines.values.iter_mut().zip(places) {
                let ends = stretch.channel(*place).map_or([f64::NAN; 2], Extremes::ends);
                values.push(ends[0]);
                values.extend(several.then_some(ends[1]));
            }
        }
        lines
    }

    /// The number at a place, from 0, as states over time.
    pub fn states(&self, place: usize) -> States {
        let mut states = States::default();
        for (after_gap, stretch) in self.pieces() {
            let extremes = stretch.channel(place);
            if after_gap || extremes.is_none() {
                states.gap();
            }
            let samples = extremes.into_iter().flat_map(Extremes::samples);
            samples.for_each(|sample| states.see(sample.time, sample.value as u64));
        }
        states
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn finite(values: &[f64]) -> Vec<Option<f64>> {
        values.iter().map(|x| x.is_finite().then_some(*x)).collect()
    }

    #[test]
    fn what_was_seen_comes_back_with_its_gaps() {
        let mut track = Track::with_gaps();
        track.see(10, 0.0, &[1.0, 10.0]);
        track.see(11, 1.0, &[2.0, f64::INFINITY]);
        track.see(14, 4.0, &[3.0, 30.0]);
        let lines = track.lines(&[0, 1]);
        assert_eq!(finite(&lines.times), [Some(0.0), Some(1.0), None, Some(4.0)]);
        assert_eq!(finite(&lines.values[0]), [Some(1.0), Some(2.0), None, Some(3.0)]);
        assert_eq!(finite(&lines.values[1]), [Some(10.0), None, None, Some(30.0)]);
        assert_eq!(track.last(0), Some(3.0));
        assert_eq!(track.range(1), Some(Range { low: 10.0, high: 30.0 }));
        assert_eq!(track.range(2), None);
        let mut without = Track::default();
        without.see(10, 0.0, &[1.0]);
        without.see(14, 4.0, &[3.0]);
        assert_eq!(without.lines(&[0]).times, [0.0, 4.0]);
    }

    /// A ramp of 1 000 003 values with one peak, one dip and one gap.
    #[test]
    fn a_long_track_stays_bounded_and_keeps_every_peak_and_long_gap() {
        let mut track = Track::with_gaps();
        let value = |i: u32| match i {
            123_457 => 50.0,
            777_777 => -70.0,
            _ => f64::from(i) * 1e-6,
        };
        for i in (0..1_000_003).filter(|i| !(400_000..500_000).contains(i)) {
            track.see(u64::from(i), f64::from(i), &[value(i)]);
        }
        let lines = track.lines(&[0]);
        assert!(lines.times.len() <= 2 * CAPACITY + 1 && lines.times.len() > CAPACITY / 2);
        assert_eq!(track.range(0), Some(Range { low: -70.0, high: 50.0 }));
        assert!(lines.values[0].contains(&50.0) && lines.values[0].contains(&-70.0));
        let gaps: Vec<usize> = (0..lines.times.len()).filter(|i| lines.times[*i].is_nan()).collect();
        assert_eq!(gaps.len(), 1);
        assert!((lines.times[gaps[0] - 1] - 399_999.0).abs() < 0.5);
        assert!((lines.times[gaps[0] + 1] - 500_000.0).abs() < 0.5);
        // A stretch is drawn from its first to its last sample, in order of time.
        let times: Vec<f64> = lines.times.iter().copied().filter(|time| time.is_finite()).collect();
        assert!(times.windows(2).all(|pair| pair[0] <= pair[1]));
        assert!((times[times.len() - 1] - 1_000_002.0).abs() < 0.5);
        assert_eq!(track.last(0), Some(value(1_000_002)));
    }

    #[test]
    fn very_many_gaps_stay_bounded_too() {
        let mut track = Track::with_gaps();
        for i in 0..100_000_u32 {
            track.see(2 * u64::from(i), f64::from(i), &[f64::from(i)]);
        }
        assert!(track.stretches.len() <= CAPACITY);
        assert_eq!(track.range(0), Some(Range { low: 0.0, high: 99_999.0 }));
    }

    /// Two processes see one in three of 60 000 steps together, and the others alone, at different times and partly with
    /// different numbers.
    #[test]
    fn the_order_in_which_processes_are_heard_makes_no_difference() {
        let of = |process: u32| {
            let steps = (0..60_000_u32).filter(move |step| step % 3 == process || step % 3 == 2);
            steps.map(move |step| {
                let at = f64::from(step) * 1e-3 + f64::from(process) * 1e-5;
                (
                    u64::from(step),
                    at,
                    [f64::from(step * 7919 % 1009) + f64::from(process % 2), f64::from(step / 9 % 2)],
                )
            })
        };
        let drawn = |seen: Vec<(u64, f64, [f64; 2])>| {
            let mut track = Track::with_gaps();
            seen.iter().for_each(|(step, time, values)| track.see(*step, *time, values));
            let lines = track.lines(&[0, 1]);
            let ends = [track.last(0), track.last(1)];
            (lines.times, lines.values, track.states(1).spells().to_vec(), ends, track.range(0))
        };
        let one_after_the_other = drawn(of(0).chain(of(1)).collect());
        let the_other_first = drawn(of(1).chain(of(0)).collect());
        assert_eq!(one_after_the_other, the_other_first);
        let mut mixed: Vec<_> = of(0).chain(of(1)).collect();
        mixed.sort_by_key(|(step, ..)| *step);
        assert_eq!(one_after_the_other, drawn(mixed.clone()));
        // Some are heard in bursts, and twice.
        let bursts: Vec<_> = mixed.chunks(700).rev().flat_map(|burst| burst.repeat(2)).collect();
        assert_eq!(one_after_the_other, drawn(bursts));
    }

    /// Off but for one step of 30 000, in a stretch of several steps.
    #[test]
    fn a_state_of_one_step_is_not_lost_in_a_long_run() {
        let mut track = Track::with_gaps();
        for step in 0..30_000_u32 {
            track.see(u64::from(step), f64::from(step), &[f64::from(u8::from(step == 12_345))]);
        }
        assert!(track.doublings > 1);
        let states = track.states(0);
        let on: Vec<_> = states.spells().iter().filter(|spell| spell.state == Some(1)).collect();
        assert_eq!(on.len(), 1);
        assert!((on[0].time.low - 12_345.0).abs() < 0.5 && on[0].time.high < 12_345.0 + 16.0);
    }
}
