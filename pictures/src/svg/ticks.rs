//! Ticks of an axis: round numbers.
//!
//! In: the range of the values. Out: the round numbers in it or around it, and their labels.

use super::axis::Range;

/// Multiples of 1, 2 or 5 times a power of ten over a range.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ticks {
    /// The first tick is `first * step`.
    first: i64,
    /// The last tick is `last * step`.
    last: i64,
    /// Between ticks, > 0.
    step: f64,
}

impl Ticks {
    /// The smallest step of 1, 2, 5, 10 .. that covers the range in at most `most` steps; the first and the last tick lie
    /// outside of the range, or at its ends.
    #[must_use]
    pub fn around(range: Range, most: u32) -> Ticks {
        let step = step(range.width(), most);
        let first = (range.low / step + 1e-9).floor() as i64;
        let last = (range.high / step - 1e-9).ceil() as i64;
        Ticks { first, last, step }
    }

    /// The same ticks, but only those inside of the range.
    #[must_use]
    pub fn inside(range: Range, most: u32) -> Ticks {
        let step = step(range.width(), most);
        let first = (range.low / step - 1e-9).ceil() as i64;
        let last = (range.high / step + 1e-9).floor() as i64;
        Ticks { first, last, step }
    }

    /// From the first tick to the last.
    #[must_use]
    pub fn range(&self) -> Range {
        Range { low: self.first as f64 * self.step, high: self.last as f64 * self.step }
    }

    /// The ticks, from low to high.
    pub fn values(&self) -> impl Iterator<Item = f64> + '_ {
        (self.first..=self.last).map(|i| i as f64 * self.step)
    }

    /// A tick with as many digits as the step needs, and a true minus sign.
    #[must_use]
    pub fn label(&self, value: f64) -> String {
        let text = self.with_digits(value, 0);
        if text.bytes().all(|c| matches!(c, b'0' | b'.')) { "0".to_owned() } else { text }
    }

    /// A value with two digits more than a tick.
    #[must_use]
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_the_finest_round_steps_that_are_few_enough() {
        for (low, high) in [(0.0, 1.0), (-0.3, 0.7), (0.0, 4.02), (-1e-4, 3e-5), (12.0, 7200.0), (0.99, 1.01)]
        {
            for most in [2, 4, 5, 8] {
                let ticks = Ticks::around(Range { low, high }, most);
                let mantissa = ticks.step / 10_f64.powf(ticks.step.log10().floor() + 1e-12);
                assert!([1.0, 2.0, 5.0, 10.0].iter().any(|m| (mantissa / m - 1.0).abs() < 1e-9), "{ticks:?}");
                assert!((high - low) / ticks.step <= f64::from(most) + 1e-6);
                // A finer round step would be too many.
                assert!((high - low) / (ticks.step * 0.4) > f64::from(most) * 0.99, "{ticks:?}");
                let covered = ticks.range();
                assert!(covered.low <= low + 1e-9 * ticks.step && covered.low > low - ticks.step * 1.0001);
                assert!(
                    covered.high >= high - 1e-9 * ticks.step && covered.high < high + ticks.step * 1.0001
                );
                let inside = Ticks::inside(Range { low, high }, most);
                assert!(
                    inside.values().all(|v| v >= low - 1e-6 * ticks.step && v <= high + 1e-6 * ticks.step)
                );
            }
        }
    }

    #[test]
    fn labels_have_the_digits_of_the_step() {
        let ticks = Ticks::around(Range { low: -0.2, high: 0.5 }, 4);
        assert_eq!(
            ticks.values().map(|v| ticks.label(v)).collect::<Vec<_>>(),
            ["−0.2", "0", "0.2", "0.4", "0.6"]
        );
        assert_eq!([0.1234, -0.0001, -0.25].map(|v| ticks.figure(v)), ["0.123", "0.000", "−0.250"]);
        let ticks = Ticks::around(Range { low: 0.0, high: 40.0 }, 4);
        assert_eq!(ticks.values().map(|v| ticks.label(v)).collect::<Vec<_>>(), ["0", "10", "20", "30", "40"]);
    }
}
