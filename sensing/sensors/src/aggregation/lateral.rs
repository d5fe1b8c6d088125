//! Where parts that pass a triangulation sensor lie across the belt.
//!
//! A value is of a part if it is nearer than a threshold; zeros and what is off the curve are invalid and dropped. A part gives a
//! burst of values, of which the first and the last may have seen the part for a share of their time only: the distance is the
//! median.

/// A part that has passed the sensor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lateral {
    /// From the sensor to its near side \[m\].
    pub distance: f64,
    /// When its last value was finished \[s\].
    pub last: f64,
    /// How many values it gave.
    pub values: u32,
}

/// Makes distances of codes.
#[derive(Clone, Copy, Debug)]
pub struct Laterals {
    floor: f64,
    nearest: f64,
    farthest: f64,
    burst: [f64; Laterals::MOST],
    values: usize,
    last: f64,
    /// Values in a row that are of no part.
    gap: u32,
    newest: Option<Lateral>,
    count: u32,
    invalid: u32,
    taken: f64,
}

impl Laterals {
    /// So many values of one part are counted at most.
    const MOST: usize = 256;
    /// A burst is over after so many values of no part; one may be missing in its middle.
    const GAP: u32 = 2;
    /// A burst is also over where no value was taken for so long: the sensor was not read, and may have seen other parts since \[s\].
    const UNREAD: f64 = 0.15;

    /// Parts are at `nearest` to `farthest` \[m\]; codes below `floor` are invalid.
    #[must_use]
    pub const fn new(nearest: f64, farthest: f64, floor: f64) -> Self {
        Self {
            floor,
            nearest,
            farthest,
            burst: [0.0; Self::MOST],
            values: 0,
            last: 0.0,
            gap: 0,
            newest: None,
            count: 0,
            invalid: 0,
            taken: f64::NEG_INFINITY,
        }
    }

    /// How many parts have passed.
    #[must_use]
    pub const fn count(&self) -> u32 {
        self.count
    }

    /// How many values were invalid.
    #[must_use]
    pub const fn invalid(&self) -> u32 {
        self.invalid
    }

    /// The newest part, be it still there or not.
    #[must_use]
    pub const fn newest(&self) -> Option<Lateral> {
        self.newest
    }

    /// Takes a value that was finished at `time` \[s\]: the distance \[m\] that its code says. One that was taken before is not taken
    /// again.
    pub fn take(&mut self, time: f64, code: u32, distance: impl Fn(f64) -> f64) {
        if time <= self.taken {
            return;
        }
        if time - self.taken > Self::UNREAD {
            (self.values, self.gap) = (0, 0);
        }
        self.taken = time;
        let code = f64::from(code);
        if code < self.floor {
            // Neither a part nor none.
            self.invalid += 1;
            return;
        }
        let distance = distance(code);
        if !(self.nearest..=self.farthest).contains(&distance) {
            self.gap += 1;
            if self.gap == Self::GAP {
                self.values = 0;
            }
            return;
        }
        self.gap = 0;
        if self.values == 0 {
            self.count += 1;
        }
        if self.values < Self::MOST {
            self.burst[self.values] = distance;
            self.values += 1;
        }
        self.last = time;
        self.newest = Some(Lateral { distance: self.median(), last: self.last, values: self.values as u32 });
    }

    fn median(&self) -> f64 {
        let mut sorted = self.burst;
        let sorted = &mut sorted[..self.values];
        sorted.sort_unstable_by(f64::total_cmp);
        let middle = sorted.len() / 2;
        if sorted.len().is_multiple_of(2) {
            0.5 * (sorted[middle - 1] + sorted[middle])
        } else {
            sorted[middle]
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 1000 / code, in metres.
    fn curve(code: f64) -> f64 {
        10.0 / code
    }

    fn after(codes: &[u32]) -> Laterals {
        let mut laterals = Laterals::new(0.03, 0.06, 50.0);
        codes.iter().enumerate().for_each(|(i, &code)| laterals.take(0.038 * i as f64, code, curve));
        laterals
    }

    #[test]
    fn a_part_is_the_median_of_its_values_and_zeros_are_dropped() {
        // The first has seen it half of the time; one value is a zero.
        let laterals = after(&[100, 100, 180, 250, 0, 250, 200, 250, 100, 100, 100]);
        let newest = laterals.newest().expect("a part");
        assert_eq!((laterals.count(), laterals.invalid(), newest.values), (1, 1, 5));
        assert!((newest.distance - 0.04).abs() < 1e-12 && (newest.last - 0.038 * 7.0).abs() < 1e-12);
    }

    #[test]
    fn parts_apart_by_two_values_of_none_are_two() {
        assert_eq!(after(&[250, 250, 100, 250]).count(), 1);
        let two = after(&[250, 250, 100, 100, 200]);
        assert_eq!(two.count(), 2);
        assert!((two.newest().expect("a part").distance - 0.05).abs() < 1e-12);
    }

    #[test]
    fn a_part_that_comes_after_a_time_without_values_is_another_one() {
        let mut laterals = after(&[250, 250, 250]);
        laterals.take(5.0, 200, curve);
        let newest = laterals.newest().expect("a part");
        assert_eq!((laterals.count(), newest.values), (2, 1));
        assert!((newest.distance - 0.05).abs() < 1e-12, "none of the first one's values: {newest:?}");
    }

    #[test]
    fn a_value_that_is_asked_for_twice_counts_once() {
        let mut laterals = Laterals::new(0.03, 0.06, 50.0);
        (0..5).for_each(|_| laterals.take(1.0, 250, curve));
        assert_eq!(laterals.newest().map(|newest| newest.values), Some(1));
    }
}
