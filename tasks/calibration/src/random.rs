//! Normally distributed random numbers.

use core::f64::consts::TAU;

use mrroc::random::Random;

/// Normally distributed, of standard deviation 1 (Box and Muller).
pub fn normal(random: &mut Random) -> f64 {
    let radius = (-2.0 * random.unit().max(f64::MIN_POSITIVE).ln()).sqrt();
    radius * (TAU * random.unit()).cos()
}
