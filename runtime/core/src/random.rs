//! Seeded random numbers, and numbers that are spread evenly: for simulations, tests and searches.
//!
//! In: a seed. Out: numbers, which are the same for the same seed on every machine.

use core::f64::consts::TAU;

/// SplitMix64 (Steele, Lea, Flood, *Fast splittable pseudorandom number generators*, 2014): one chain of multiplications for each number.
#[derive(Clone, Copy, Debug)]
pub struct Random(u64);

impl Random {
    /// The same numbers for the same seed.
    #[must_use]
    pub const fn seeded(seed: u64) -> Self {
        Self(seed)
    }

    /// 64 bits, each as often 0 as 1.
    #[inline]
    pub const fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Uniform in 0..1.
    #[inline]
    pub fn unit(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Uniform in `lower..upper`.
    #[inline]
    pub fn between(&mut self, lower: f64, upper: f64) -> f64 {
        lower + (upper - lower) * self.unit()
    }

    /// Uniform in -`most`..`most`.
    #[inline]
    pub fn within(&mut self, most: f64) -> f64 {
        most * (2.0 * self.unit() - 1.0)
    }

    /// A whole number in 0..`end`; 0 where `end` is 0.
    #[inline]
    pub fn below(&mut self, end: usize) -> usize {
        (self.bits() % end.max(1) as u64) as usize
    }
}

/// The bases of a Halton sequence.
const PRIMES: [usize; 32] = [
    2, 3, 5, 7, 11, 13, 17, 19, 23, 29, 31, 37, 41, 43, 47, 53, 59, 61, 67, 71, 73, 79, 83, 89, 97, 101, 103,
    107, 109, 113, 127, 131,
];

/// A coordinate of a point of the Halton sequence, in 0..1: the points fill a cube evenly, the same in every run. From the 33rd on,
/// coordinates are those of the first ones again.
///
/// It has the digits of `index` in the coordinate's prime, in reverse behind the point (Halton 1960).
#[must_use]
pub fn halton(index: usize, coordinate: usize) -> f64 {
    let prime = PRIMES[coordinate % PRIMES.len()];
    let (mut rest, mut part, mut digit) = (index, 0.0, 1.0);
    while rest > 0 {
        digit /= prime as f64;
        part += digit * (rest % prime) as f64;
        rest /= prime;
    }
    part
}

/// Noise from such numbers: normally distributed by the transform of Box and Muller (1958), which takes no 0.
#[derive(Clone, Copy, Debug)]
pub struct Noise(Random);

impl Noise {
    /// The same numbers for the same seed.
    #[must_use]
    pub const fn seeded(seed: u64) -> Self {
        Self(Random::seeded(seed))
    }

    /// Uniform above 0, up to 1.
    #[inline]
    pub fn uniform(&mut self) -> f64 {
        self.0.unit() + 1.0 / (1_u64 << 54) as f64
    }

    /// Uniform between two numbers.
    #[inline]
    pub fn between(&mut self, lower: f64, upper: f64) -> f64 {
        lower + (upper - lower) * self.uniform()
    }

    /// Two that are independent, each of mean 0 and standard deviation 1.
    #[inline]
    pub fn normals(&mut self) -> [f64; 2] {
        let radius = (-2.0 * self.uniform().ln()).sqrt();
        let (sin, cos) = (TAU * self.uniform()).sin_cos();
        [radius * cos, radius * sin]
    }

    /// Of mean 0 and standard deviation 1.
    #[inline]
    pub fn normal(&mut self) -> f64 {
        let radius = (-2.0 * self.uniform().ln()).sqrt();
        radius * (TAU * self.uniform()).cos()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_those_of_the_paper_and_keep_to_their_range() {
        // The first numbers of the reference implementation, splitmix64.c, from seed 1234567.
        let mut random = Random::seeded(1_234_567);
        assert_eq!(random.bits(), 6_457_827_717_110_365_317);
        assert_eq!(random.bits(), 3_203_168_211_198_807_973);
        let mut seen = [0; 7];
        for _ in 0..7000 {
            seen[random.below(7)] += 1;
        }
        // 1000 each, within five standard deviations of sqrt(7000 · 6/49) = 29.
        assert!(seen.iter().all(|n| (855..1145).contains(n)), "{seen:?}");
    }

    #[test]
    fn coordinates_of_the_halton_sequence_are_digits_in_reverse() {
        let third = 1.0 / 3.0;
        // 6 is 110 in base 2, 20 in base 3 and 11 in base 5.
        assert_eq!((halton(6, 0), halton(0, 4)), (0.375, 0.0));
        assert!((halton(6, 1) - 2.0 * third * third).abs() < 1e-15 && (halton(6, 2) - 0.24).abs() < 1e-15);
        assert_eq!(halton(5, 32), halton(5, 0));
    }

    #[test]
    fn noise_has_the_moments_of_its_distributions() {
        let (mut noise, n) = (Noise::seeded(7), 100_000);
        let (mut first, mut second, mut fourth, mut uniform) = (0.0, 0.0, 0.0, 0.0);
        for _ in 0..n {
            let x = noise.normal();
            first += x / f64::from(n);
            second += x * x / f64::from(n);
            fourth += x.powi(4) / f64::from(n);
            uniform += noise.between(-1.0, 3.0) / f64::from(n);
        }
        // Standard errors: sqrt(1/n), sqrt(2/n), sqrt(96/n), sqrt(16/12n); five of them.
        assert!(first.abs() < 0.016 && (second - 1.0).abs() < 0.023 && (fourth - 3.0).abs() < 0.16);
        assert!((uniform - 1.0).abs() < 0.019);
    }
}
