//! Seeded Gaussian noise.

use core::f64::consts::TAU;

/// Normally distributed numbers from SplitMix64 (Steele, Lea, Flood 2014) by the transform of Box and Muller (1958).
#[derive(Clone, Copy, Debug)]
pub(super) struct Noise(u64);

impl Noise {
    pub fn seeded(seed: u64) -> Self {
        Self(seed)
    }

    /// Uniform above 0, up to 1.
    fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64 + 1.0 / (1_u64 << 54) as f64
    }

    /// Of mean 0 and standard deviation 1.
    pub fn normal(&mut self) -> f64 {
        let radius = (-2.0 * self.uniform().ln()).sqrt();
        radius * (TAU * self.uniform()).cos()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_has_the_moments_of_the_normal_distribution() {
        let mut noise = Noise::seeded(7);
        let n = 100_000;
        let (mut first, mut second, mut fourth) = (0.0, 0.0, 0.0);
        for _ in 0..n {
            let x = noise.normal();
            first += x / f64::from(n);
            second += x * x / f64::from(n);
            fourth += x.powi(4) / f64::from(n);
        }
        // Standard errors: sqrt(1/n), sqrt(2/n), sqrt(96/n); five of them.
        assert!(first.abs() < 0.016 && (second - 1.0).abs() < 0.023 && (fourth - 3.0).abs() < 0.16);
    }
}
