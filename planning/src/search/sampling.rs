//! Positions spread evenly over the ranges of the joints.

use mrroc::random::{Random, halton};

/// A Halton sequence within ranges, shifted by a seed.
pub(crate) struct Samples {
    index: usize,
    shift: Vec<f64>,
    lower: Vec<f32>,
    upper: Vec<f32>,
}

impl Samples {
    /// Between `lower` and `upper` [rad or m].
    pub(crate) fn new(seed: u64, lower: &[f32], upper: &[f32]) -> Self {
        let mut random = Random::seeded(seed);
        let shift = lower.iter().map(|_| random.unit()).collect();
        Samples { index: 0, shift, lower: lower.to_vec(), upper: upper.to_vec() }
    }

    /// The next one.
    pub(crate) fn next(&mut self, q: &mut [f32]) {
        self.index += 1;
        for (j, q) in q.iter_mut().enumerate() {
            let share = (halton(self.index, j) + self.shift[j]).fract();
            *q = self.lower[j] + (self.upper[j] - self.lower[j]) * share as f32;
        }
    }
}
