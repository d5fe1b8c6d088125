//! Positions spread evenly over the ranges of the joints.

use core::ops::Range;

use mrroc::random::{Random, halton};

/// A Halton sequence within ranges, shifted by a seed.
pub(crate) struct Samples {
    seed: u64,
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
        Samples { seed, index: 0, shift, lower: lower.to_vec(), upper: upper.to_vec() }
    }

    /// Of some of the joints, other ones for each `number`; the other joints stay where they are `at`.
    pub(crate) fn of(&self, joints: Range<usize>, at: &[f32], number: u64) -> Samples {
        let [mut lower, mut upper] = [at.to_vec(), at.to_vec()];
        lower[joints.clone()].copy_from_slice(&self.lower[joints.clone()]);
        upper[joints.clone()].copy_from_slice(&self.upper[joints.clone()]);
        Samples::new(self.seed ^ number, &lower, &upper)
    }

    /// The seed.
    pub(crate) fn seed(&self) -> u64 {
        self.seed
    }

    /// The ranges of some joints.
    pub(crate) fn ranges(&self, joints: Range<usize>) -> Vec<[f32; 2]> {
        joints.map(|j| [self.lower[j], self.upper[j]]).collect()
    }

    /// The next one.
    pub(crate) fn next(&mut self, q: &mut [f32]) {
        self.index += 1;
        let mut coordinate = 0;
        for (j, q) in q.iter_mut().enumerate() {
            // What stays where it is takes none of the coordinates, the first of which are the most even.
            if self.lower[j] == self.upper[j] {
                *q = self.lower[j];
                continue;
            }
            let share = (halton(self.index, coordinate) + self.shift[j]).fract();
            coordinate += 1;
            *q = self.lower[j] + (self.upper[j] - self.lower[j]) * share as f32;
        }
    }
}
