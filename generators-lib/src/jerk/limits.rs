//! What an axis may do, where it is, where it is to go, and why that may not make a plan.

use thiserror::Error;

/// Limits of one axis; `m` stands for m or rad.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AxisLimits {
    /// Largest velocity [m/s], finite, > 0.
    pub max_velocity: f64,
    /// Least velocity [m/s], finite, < 0.
    pub min_velocity: f64,
    /// Largest acceleration [m/s^2], finite, > 0.
    pub max_acceleration: f64,
    /// Least acceleration [m/s^2], finite, < 0.
    pub min_acceleration: f64,
    /// Largest magnitude of the jerk [m/s^3], finite, > 0.
    pub jerk: f64,
}

/// State of one axis.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct AxisState {
    /// Position \[m\].
    pub position: f64,
    /// Velocity [m/s].
    pub velocity: f64,
    /// Acceleration [m/s^2].
    pub acceleration: f64,
}

/// Where an axis is to arrive.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct AxisTarget {
    /// Position \[m\].
    pub position: f64,
    /// Velocity [m/s].
    pub velocity: f64,
    /// Acceleration [m/s^2].
    pub acceleration: f64,
}

/// Why an axis has no plan.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum JerkError {
    /// A limit has the wrong sign, or is not finite.
    #[error("{name} limit {value} must be finite and {sign} 0")]
    Limit {
        /// Which.
        name: &'static str,
        /// Its value, SI.
        value: f64,
        /// `>` or `<`.
        sign: char,
    },
    /// A number that is to be reached or left is infinite or not a number.
    #[error("{name} {value} must be finite")]
    NotFinite {
        /// Which.
        name: &'static str,
        /// Its value, SI.
        value: f64,
    },
    /// A minimum of the duration is negative, infinite or not a number.
    #[error("minimum duration {0} s must be finite and not negative")]
    MinimumDuration(f64),
    /// A number of the target lies outside its limits.
    #[error("{name} {value} lies outside its limits {low} to {high}")]
    Outside {
        /// Which.
        name: &'static str,
        /// Its value, SI.
        value: f64,
        /// Least value allowed.
        low: f64,
        /// Largest value allowed.
        high: f64,
    },
    /// A duration was asked for in which the target cannot be reached within the limits.
    #[error(
        "the target is reached in {least} s, or in {next} s, but not in the {asked} s that were asked for"
    )]
    Duration {
        /// Duration asked for \[s\].
        asked: f64,
        /// Shortest duration \[s\].
        least: f64,
        /// The next longer one that is possible \[s\].
        next: f64,
    },
    /// Distances and limits are so many orders of magnitude apart that double precision misses the target.
    #[error("the plan misses its target by {0}: its numbers are too many orders of magnitude apart")]
    Precision(f64),
}

impl AxisLimits {
    /// The same in both directions: `velocity` [m/s], `acceleration` [m/s^2], `jerk` [m/s^3], all finite, > 0.
    #[must_use]
    pub fn symmetric(velocity: f64, acceleration: f64, jerk: f64) -> Self {
        AxisLimits {
            max_velocity: velocity,
            min_velocity: -velocity,
            max_acceleration: acceleration,
            min_acceleration: -acceleration,
            jerk,
        }
    }

    /// Checks every limit.
    ///
    /// # Errors
    /// The first that has the wrong sign or is not finite.
    pub fn validate(&self) -> Result<(), JerkError> {
        let all = [
            ("velocity", self.max_velocity, '>'),
            ("velocity", self.min_velocity, '<'),
            ("acceleration", self.max_acceleration, '>'),
            ("acceleration", self.min_acceleration, '<'),
            ("jerk", self.jerk, '>'),
        ];
        for (name, value, sign) in all {
            let right = if sign == '>' { value > 0.0 } else { value < 0.0 };
            if !(right && value.is_finite()) {
                return Err(JerkError::Limit { name, value, sign });
            }
        }
        Ok(())
    }

    /// The limits seen from the other direction.
    pub(super) fn mirrored(&self) -> Self {
        AxisLimits {
            max_velocity: -self.min_velocity,
            min_velocity: -self.max_velocity,
            max_acceleration: -self.min_acceleration,
            min_acceleration: -self.max_acceleration,
            jerk: self.jerk,
        }
    }

    /// Checks that a start is a number and a target within the limits, and need not come from outside.
    pub(super) fn check(&self, from: &AxisState, to: &AxisTarget) -> Result<(), JerkError> {
        let finite = [
            ("start position", from.position),
            ("start velocity", from.velocity),
            ("start acceleration", from.acceleration),
            ("target position", to.position),
            ("target velocity", to.velocity),
            ("target acceleration", to.acceleration),
        ];
        for (name, value) in finite {
            if !value.is_finite() {
                return Err(JerkError::NotFinite { name, value });
            }
        }
        // Where the velocity comes from while the jerk builds the acceleration up.
        let before = to.velocity - to.acceleration * to.acceleration.abs() / (2.0 * self.jerk);
        let velocities = (self.min_velocity, self.max_velocity);
        let within = [
            ("target acceleration", to.acceleration, (self.min_acceleration, self.max_acceleration)),
            ("target velocity", to.velocity, velocities),
            ("velocity inevitable before the target", before, velocities),
        ];
        for (name, value, (low, high)) in within {
            if !(value >= low - slack(low, high) && value <= high + slack(low, high)) {
                return Err(JerkError::Outside { name, value, low, high });
            }
        }
        Ok(())
    }

    /// Whether a start is within the limits and need not leave them.
    pub(super) fn allow(&self, from: &AxisState) -> bool {
        let within = |value: f64, low: f64, high: f64| {
            value >= low - slack(low, high) && value <= high + slack(low, high)
        };
        within(from.acceleration, self.min_acceleration, self.max_acceleration)
            && within(from.velocity, self.min_velocity, self.max_velocity)
            && within(self.inevitable(from), self.min_velocity, self.max_velocity)
    }

    /// Where the velocity gets while the jerk ends the acceleration.
    fn inevitable(&self, from: &AxisState) -> f64 {
        from.velocity + from.acceleration * from.acceleration.abs() / (2.0 * self.jerk)
    }

    /// The limits, widened by the rounding that [`Self::allow`] lets pass.
    pub(super) fn around(&self, from: &AxisState) -> Self {
        let inevitable = self.inevitable(from);
        AxisLimits {
            max_velocity: self.max_velocity.max(inevitable),
            min_velocity: self.min_velocity.min(inevitable),
            max_acceleration: self.max_acceleration.max(from.acceleration),
            min_acceleration: self.min_acceleration.min(from.acceleration),
            jerk: self.jerk,
        }
    }
}

/// By how much a state computed on a plan may exceed a limit: by rounding.
fn slack(low: f64, high: f64) -> f64 {
    1e-11 * (high - low)
}
