//! Positions spread evenly over the ranges of the joints.

use mrroc::random::Random;

/// One for each joint.
const PRIMES: [u32; 32] = [
    2, 3, 5, 7, 11, 13, 17, 19, 23, 29, 31, 37, 41, 43, 47, 53, 59, 61, 67, 71, 73, 79, 83, 89, 97, 101, 103,
    107, 109, 113, 127, 131,
];

/// A Halton sequence within ranges, shifted by a seed.
pub(crate) struct Samples {
    index: u32,
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
            let share = (radical_inverse(self.index, PRIMES[j % PRIMES.len()]) + self.shift[j]).fract();
            *q = self.lower[j] + (self.upper[j] - self.lower[j]) * share as f32;
        }
    }
}

/// The digits of a number in a base, behind the point and in reverse.
fn radical_inverse(mut index: u32, base: u32) -> f64 {
    let (mut share, mut digit) = (0.0, 1.0 / f64::from(base));
    while index > 0 {
        share += digit * f64::from(index % base);
        digit /= f64::from(base);
        index /= base;
    }
    share
}
