//! What the drives of a robot bear, and whether a way keeps it.

use mrroc::CoupledLimit;
use nalgebra::SVector;

/// What the motors of a robot bear.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MotorLimits<const N: usize> {
    /// Lowest motor angles \[rad\].
    pub lower: [f64; N],
    /// Highest motor angles \[rad\], above `lower`.
    pub upper: [f64; N],
    /// Largest speed of every motor [rad/s], > 0.
    pub speed: f64,
}

/// Whether the motors may go from the angles `before` to `after` \[rad\] in `duration` \[s\].
pub(crate) fn check_motors<const N: usize>(
    before: &SVector<f64, N>,
    after: &SVector<f64, N>,
    limits: &MotorLimits<N>,
    duration: f64,
) -> Result<(), CoupledLimit> {
    for i in 0..N {
        let (lower, upper) = (limits.lower[i], limits.upper[i]);
        let limit = if after[i] < lower { lower } else { upper };
        if !(lower..=upper).contains(&after[i]) {
            let what = "angle of the motor";
            return Err(CoupledLimit { joint: i, what, actual: after[i], limit, unit: "rad" });
        }
        let speed = (after[i] - before[i]).abs() / duration;
        if speed > limits.speed {
            let (what, limit) = ("speed of the motor", limits.speed);
            return Err(CoupledLimit { joint: i, what, actual: speed, limit, unit: "rad/s" });
        }
    }
    Ok(())
}
