//! An axis: from values to the page.
//!
//! In: the range of the values and where it lies on the page. Out: where a value is.

/// A range of values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range {
    /// The least.
    pub low: f64,
    /// The greatest, at least the least.
    pub high: f64,
}

/// The share of a range that is not worth a tick of its own.
const PLAY: f64 = 0.02;

impl Range {
    /// Of no values yet: from infinity to minus infinity.
    pub const NOTHING: Range = Range { low: f64::INFINITY, high: f64::NEG_INFINITY };

    /// From the least to the greatest of some values; 0 to 0 of none. What is not a number does not count.
    #[must_use]
    pub fn of<'a>(values: impl IntoIterator<Item = &'a f64>) -> Range {
        let range = values.into_iter().fold(Range::NOTHING, |range, value| range.with(*value));
        if range.low <= range.high { range } else { Range { low: 0.0, high: 0.0 } }
    }

    /// The range of an axis that shows some values and 0: at least `least` wide; what lies beyond 0 by a fiftieth of the
    /// rest, such as a drive's play, is left out.
    #[must_use]
    pub fn with_zero<'a>(values: impl IntoIterator<Item = &'a f64>, least: f64) -> Range {
        let Range { mut low, mut high } = Range::of(values.into_iter().chain(&[0.0]));
        if high - low < least {
            let middle = 0.5 * (low + high);
            low = middle - 0.5 * least;
            high = middle + 0.5 * least;
        }
        low = if low > -PLAY * high { 0.0 } else { low };
        high = if high < -PLAY * low { 0.0 } else { high };
        Range { low, high }
    }

    /// The same, widened so that it holds this value.
    #[must_use]
    pub fn with(self, value: f64) -> Range {
        Range { low: self.low.min(value), high: self.high.max(value) }
    }

    /// From the least to the greatest.
    #[must_use]
    pub fn width(self) -> f64 {
        self.high - self.low
    }

    /// The same values in a unit of which `scale`, > 0, make one of the old.
    #[must_use]
    pub fn scaled(self, scale: f64) -> Range {
        Range { low: self.low * scale, high: self.high * scale }
    }
}

/// From values to one coordinate of the page: linear.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Axis {
    low: f64,
    start: f64,
    scale: f64,
}

impl Axis {
    /// Puts the least value at `start` and the greatest at `end`, in the page's unit; a range of one value lies in the
    /// middle.
    #[must_use]
    pub fn new(values: Range, start: f64, end: f64) -> Axis {
        if values.width() > 0.0 {
            return Axis { low: values.low, start, scale: (end - start) / values.width() };
        }
        Axis { low: values.low, start: 0.5 * (start + end), scale: 0.0 }
    }

    /// Where a value is, in the page's unit.
    #[must_use]
    pub fn at(&self, value: f64) -> f64 {
        self.start + (value - self.low) * self.scale
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_axis_is_linear_and_a_range_of_nothing_lies_in_the_middle() {
        let axis = Axis::new(Range { low: 1.0, high: 3.0 }, 100.0, 50.0);
        assert_eq!([1.0, 2.0, 3.0].map(|v| axis.at(v)), [100.0, 75.0, 50.0]);
        assert_eq!(Axis::new(Range { low: 2.0, high: 2.0 }, 0.0, 10.0).at(7.0), 5.0);
    }

    #[test]
    fn a_range_holds_its_values_and_zero_and_is_as_wide_as_told() {
        assert_eq!(Range::of(&[2.0, f64::NAN, -1.0]), Range { low: -1.0, high: 2.0 });
        assert_eq!(Range::of(&[]), Range { low: 0.0, high: 0.0 });
        assert_eq!(Range::with_zero(&[2.0, 3.0], 0.0), Range { low: 0.0, high: 3.0 });
        assert_eq!(Range::with_zero(&[-0.03, 3.0], 0.0), Range { low: 0.0, high: 3.0 });
        assert_eq!(Range::with_zero(&[-3.0, 0.03], 0.0), Range { low: -3.0, high: 0.0 });
        assert_eq!(Range::with_zero(&[-0.3, 3.0], 0.0), Range { low: -0.3, high: 3.0 });
        assert_eq!(Range::with_zero(&[], 2.0), Range { low: -1.0, high: 1.0 });
    }
}
