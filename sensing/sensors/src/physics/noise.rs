//! Seeded noise.

use core::f64::consts::TAU;

/// Numbers from SplitMix64 (Steele, Lea, Flood 2014), uniform, and normal by the transform of Box and Muller (1958).
#[derive(Clone, Copy, Debug)]
pub struct Noise(u64);

impl Noise {
    /// The same numbers for the same seed.
    #[must_use]
    pub const fn seeded(seed: u64) -> Self {
        Self(seed)
    }

    /// Uniform above 0, up to 1.
    pub fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64 + 1.0 / (1_u64 << 54) as f64
    }

    /// Uniform between two numbers.
    pub fn between(&mut self, lower: f64, upper: f64) -> f64 {
        lower + (upper - lower) * self.uniform()
    }

    /// Two that are independent, each of mean 0 and standard deviation 1.
    pub fn normals(&mut self) -> [f64; 2] {
        let radius = (-2.0 * self.uniform().ln()).sqrt();
        let (sin, cos) = (TAU * self.uniform()).sin_cos();
        [radius * cos, radius * sin]
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
    fn noise_has_the_moments_of_its_distributions() {
        let (mut noise, n) = (Noise::seeded(5), 100_000);
        let (mut mean, mut square, mut uniform) = (0.0, 0.0, 0.0);
        for _ in 0..n {
            let x = noise.normal();
            mean += x / f64::from(n);
            square += x * x / f64::from(n);
            uniform += noise.between(-1.0, 3.0) / f64::from(n);
        }
        // Five standard errors: sqrt(1/n), sqrt(2/n), sqrt(16/12n).
        assert!(mean.abs() < 0.016 && (square - 1.0).abs() < 0.023 && (uniform - 1.0).abs() < 0.019);
    }
}
