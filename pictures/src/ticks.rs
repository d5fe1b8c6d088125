//! Ticks of an axis: round numbers, and the line from values to the page.
//!
//! In: the range of the values. Out: a range that ends at round numbers, its ticks, and where a value is on the page.

/// Multiples of 1, 2 or 5 times a power of ten over a range.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Ticks {
    /// The first tick is `first * step`.
    first: i64,
    /// The last tick is `last * step`.
    last: i64,
    /// Between ticks, > 0.
    step: f64,
}

impl Ticks {
    /// The smallest step of 1, 2, 5, 10 .. that covers `low` to `high` in at most `most` steps; the first and the last
    /// tick lie outside of the range, or at its ends.
    pub fn around(low: f64, high: f64, most: u32) -> Ticks {
        let step = step(high - low, most);
        Ticks { first: (low / step + 1e-9).floor() as i64, last: (high / step - 1e-9).ceil() as i64, step }
    }

    /// The same ticks, but only those inside of the range.
    pub fn inside(low: f64, high: f64, most: u32) -> Ticks {
        let step = step(high - low, most);
        Ticks { first: (low / step - 1e-9).ceil() as i64, last: (high / step + 1e-9).floor() as i64, step }
    }

    pub fn low(&self) -> f64 {
        self.first as f64 * self.step
    }

    pub fn high(&self) -> f64 {
        self.last as f64 * self.step
    }

    /// The ticks, from low to high.
    pub fn values(&self) -> impl Iterator<Item = f64> + '_ {
        (self.first..=self.last).map(|i| i as f64 * self.step)
    }

    /// A tick with as many digits as the step needs.
    pub fn label(&self, value: f64) -> String {
        let text = self.with_digits(value, 0);
        if text.bytes().all(|c| matches!(c, b'0' | b'.')) { "0".to_owned() } else { text }
    }

    /// A value with a hundredth of the step's digits.
    pub fn figure(&self, value: f64) -> String {
        self.with_digits(value, 2)
    }

    fn with_digits(&self, value: f64, more: usize) -> String {
        let digits = (-(self.step.log10() + 1e-9).floor()).clamp(0.0, 12.0) as usize;
        // More than a millionth nobody reads.
        let digits = (digits + more).min(digits.max(6));
        let text = format!("{value:.digits$}");
        if text.bytes().all(|c| matches!(c, b'-' | b'0' | b'.')) {
            return text.replace('-', "");
        }
        text.replace('-', "−")
    }
}

/// The smallest of 1, 2, 5 times a power of ten that covers `range` in at most `most` steps; ends may need one more each.
/// 1 for a range of nothing.
pub(crate) fn step(range: f64, most: u32) -> f64 {
    let least = if range.is_finite() && range > 1e-12 { range / f64::from(most.max(1)) } else { 1.0 };
    let power = 10_f64.powf(least.log10().floor());
    let factor = [1.0, 2.0, 5.0].into_iter().find(|factor| factor * power >= least * (1.0 - 1e-9));
    factor.unwrap_or(10.0) * power
}

/// From values to the page: linear.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Axis {
    value: f64,
    page: f64,
    scale: f64,
}

impl Axis {
    /// Puts the values `from` and `to` at `page.0` and `page.1` \[px\]; equal values at the middle.
    pub fn new((from, to): (f64, f64), page: (f64, f64)) -> Axis {
        if to > from {
            return Axis { value: from, page: page.0, scale: (page.1 - page.0) / (to - from) };
        }
        Axis { value: from, page: 0.5 * (page.0 + page.1), scale: 0.0 }
    }

    /// Where a value is \[px\].
    pub fn at(&self, value: f64) -> f64 {
        self.page + (value - self.value) * self.scale
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_the_finest_round_steps_that_are_few_enough() {
        for (low, high) in [(0.0, 1.0), (-0.3, 0.7), (0.0, 4.02), (-1e-4, 3e-5), (12.0, 7200.0), (0.99, 1.01)]
        {
            for most in [2, 4, 5, 8] {
                let ticks = Ticks::around(low, high, most);
                let mantissa = ticks.step / 10_f64.powf(ticks.step.log10().floor() + 1e-12);
                assert!([1.0, 2.0, 5.0, 10.0].iter().any(|m| (mantissa / m - 1.0).abs() < 1e-9), "{ticks:?}");
                assert!((high - low) / ticks.step <= f64::from(most) + 1e-6);
                // A finer round step would be too many.
                assert!((high - low) / (ticks.step * 0.4) > f64::from(most) * 0.99, "{ticks:?}");
                assert!(ticks.low() <= low + 1e-9 * ticks.step && ticks.low() > low - ticks.step * 1.0001);
                assert!(
                    ticks.high() >= high - 1e-9 * ticks.step && ticks.high() < high + ticks.step * 1.0001
                );
                let inside = Ticks::inside(low, high, most);
                assert!(
                    inside.values().all(|v| v >= low - 1e-6 * ticks.step && v <= high + 1e-6 * ticks.step)
                );
            }
        }
    }

    #[test]
    fn labels_have_the_digits_of_the_step() {
        let ticks = Ticks::around(-0.2, 0.5, 4);
        assert_eq!(
            ticks.values().map(|v| ticks.label(v)).collect::<Vec<_>>(),
            ["−0.2", "0", "0.2", "0.4", "0.6"]
        );
        assert_eq!([0.1234, -0.0001, -0.25].map(|v| ticks.figure(v)), ["0.123", "0.000", "−0.250"]);
        let ticks = Ticks::around(0.0, 40.0, 4);
        assert_eq!(ticks.values().map(|v| ticks.label(v)).collect::<Vec<_>>(), ["0", "10", "20", "30", "40"]);
    }

    #[test]
    fn an_axis_is_linear_and_a_range_of_nothing_lies_in_the_middle() {
        let axis = Axis::new((1.0, 3.0), (100.0, 50.0));
        assert_eq!([1.0, 2.0, 3.0].map(|v| axis.at(v)), [100.0, 75.0, 50.0]);
        assert_eq!(Axis::new((2.0, 2.0), (0.0, 10.0)).at(7.0), 5.0);
    }
}
