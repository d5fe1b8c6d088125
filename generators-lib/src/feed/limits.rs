//! What bounds the speed along a path.

use crate::bspline::SplineError;
use thiserror::Error;

/// Limits of motion along a path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FeedLimits {
    /// Feed `F` [m/s], finite, > 0.
    pub feed: f64,
    /// Acceleration along the path `A_t` [m/s^2], finite, > 0.
    pub tangential: f64,
    /// Acceleration across the path `A_n` [m/s^2], finite, > 0.
    pub normal: f64,
    /// Step `Ts` \[s\], finite, > 0.
    pub step: f64,
    /// Largest distance `d` of a step's chord from the path \[m\], > 0; infinite where it does not matter.
    pub chord_error: f64,
    /// Jerk at constant speed `J` [m/s^3], > 0; infinite where it does not matter.
    pub jerk: f64,
}

/// Why a path cannot be followed.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum FeedError {
    /// A limit is not positive, or its square overflows or vanishes.
    #[error("{name} limit {value} must lie within 1e-100 and 1e100 (chord error and jerk: or be infinite)")]
    Limit {
        /// Which.
        name: &'static str,
        /// Its value, SI.
        value: f64,
    },
    /// A span does not begin where the one before it ends.
    #[error("span begins {0} m away from the end of the one before it")]
    Gap(f64),
    /// A span was pushed although there was no room, or after the end.
    #[error("a span was pushed although the planner did not ask for one")]
    NotAsked,
    /// The spline refused a point.
    #[error(transparent)]
    Spline(#[from] SplineError),
}

impl FeedLimits {
    /// Checks every limit.
    ///
    /// # Errors
    /// The first that is not positive, infinite where it must not be, or so small or large that its square is not a positive finite number.
    pub fn validate(&self) -> Result<(), FeedError> {
        let all = [
            ("feed", self.feed, true),
            ("tangential acceleration", self.tangential, true),
            ("normal acceleration", self.normal, true),
            ("step", self.step, true),
            ("chord error", self.chord_error, false),
            ("jerk", self.jerk, false),
        ];
        for (name, value, finite) in all {
            let unlimited = !finite && value == f64::INFINITY;
            if !(unlimited || (1e-100..=1e100).contains(&value)) {
                return Err(FeedError::Limit { name, value });
            }
        }
        Ok(())
    }

    /// Speed limit [m/s] at the curvature `k` [1/m], >= 0 or infinite.
    ///
    /// Never below `A_n Ts / 2`: at that speed even a reversal within one step stays within `A_n`.
    #[must_use]
    pub fn speed_at_curvature(&self, k: f64) -> f64 {
        // Not a number only where coordinates overflow: as careful as at a cusp.
        let radius = if k.is_nan() { 0.0 } else { 1.0 / k };
        let normal = (self.normal * radius).sqrt();
        // A chord of a circle is nowhere farther than its radius.
        let sagitta = self.chord_error.min(radius);
        let chord = if sagitta.is_finite() {
            2.0 / self.step * (sagitta * (2.0 * radius - sagitta)).sqrt()
        } else {
            f64::INFINITY
        };
        self.feed.min(normal).min(chord.max(self.slowest())).max(self.slowest())
    }

    /// Speed limit [m/s] by jerk where the third derivative by length is `p_sss` [1/m^2] in magnitude.
    #[must_use]
    pub fn speed_at_jerk(&self, p_sss: f64) -> f64 {
        if self.jerk.is_finite() { (self.jerk / p_sss).cbrt().max(self.slowest()) } else { f64::INFINITY }
    }

    /// Speed limit [m/s] where the tangent jumps by `t1 - t0 = jump` in magnitude: `A_n Ts / jump`.
    #[must_use]
    pub fn speed_at_kink(&self, jump: f64) -> f64 {
        self.normal * self.step / jump
    }

    /// Speed [m/s] at which even a reversal within one step stays within the normal acceleration.
    fn slowest(&self) -> f64 {
        (0.5 * self.normal * self.step).min(self.feed)
    }
}
