//! Speeds from positions: differences over a few samples.
//!
//! In: times and values. Out: `(x(t + w) - x(t - w)) / 2w` for each, with w two servo periods at least and the 500th part
//! of the run, so that an encoder's pulses do not drown the motion; one-sided at the ends.

/// How many samples the difference reaches to each side.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Window(usize);

impl Window {
    /// For so many samples.
    pub fn of(samples: usize) -> Window {
        Window((samples / 500).max(2))
    }

    /// The samples that the difference at sample `i` of `count` is between; none for a single sample.
    pub fn at(self, i: usize, count: usize) -> Option<(usize, usize)> {
        let (from, to) = (i.saturating_sub(self.0), (i + self.0).min(count.checked_sub(1)?));
        (from < to).then_some((from, to))
    }
}

/// The rate of change of `value(i)` at each of `times` \[s\], increasing; 0 for a single one.
pub(crate) fn rates(times: &[f64], value: impl Fn(usize, usize) -> f64) -> Vec<f64> {
    let window = Window::of(times.len());
    let rate = |i| match window.at(i, times.len()) {
        Some((from, to)) => value(from, to) / (times[to] - times[from]),
        None => 0.0,
    };
    (0..times.len()).map(rate).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_rate_of_a_sine_is_its_cosine() {
        let times: Vec<f64> = (0..2000).map(|i| f64::from(i) * 2e-3).collect();
        let rates = rates(&times, |from, to| times[to].sin() - times[from].sin());
        // Central differences err by w² / 6, one-sided ones by w.
        for (i, (time, rate)) in times.iter().zip(&rates).enumerate() {
            let bound = if (4..1996).contains(&i) { 1.1e-5 } else { 8e-3 };
            assert!((rate - time.cos()).abs() < bound, "{time}: {rate}");
        }
        assert_eq!(super::rates(&[3.0], |_, _| f64::NAN), [0.0]);
    }
}
