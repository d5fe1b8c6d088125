//! The fastest profile with a limit of jerk: up to seven phases of constant jerk.
//!
//! ```text
//! t_a = V / A + A / J, or 2 sqrt(V / J) if V < A^2 / J
//! T = D / V + t_a                           if D >= V t_a
//!     A / J + sqrt((A / J)^2 + 4 D / A)     else if D >= 2 A^3 / J^2
//!     4 cbrt(D / 2 J)                       else
//! ```

use super::{Profile, ProfileError, ProfilePoint, check_stretch, validate};
use crate::jerk::{AxisLimits, AxisPlan, AxisState, AxisTarget, JerkProfile};

/// Limits of a path scalar's rate of change, with jerk.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JerkLimits {
    /// Largest velocity [units/s], > 0.
    pub velocity: f64,
    /// Largest acceleration and deceleration [units/s^2], > 0.
    pub acceleration: f64,
    /// Largest jerk [units/s^3], > 0.
    pub jerk: f64,
}

/// A jerk-limited rest-to-rest profile.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SevenPhase {
    distance: f64,
    motion: JerkProfile,
    /// The motion's time per path time.
    rate: f64,
    duration: f64,
}

impl SevenPhase {
    /// The fastest profile over `distance` \[units\] within `limits`, all finite.
    ///
    /// # Errors
    /// A distance that is negative or not finite, or a limit that is not positive and finite.
    pub fn new(distance: f64, limits: JerkLimits) -> Result<Self, ProfileError> {
        let JerkLimits { velocity, acceleration, jerk } = limits;
        validate(distance, velocity, acceleration, jerk)?;
        let axis = AxisLimits::symmetric(velocity, acceleration, jerk);
        let target = AxisTarget { position: distance, ..AxisTarget::default() };
        let plan = AxisPlan::new(&AxisState::default(), &target, &axis);
        let plan = plan.map_err(|_| ProfileError::Precision(distance))?;
        Ok(SevenPhase { distance, motion: plan.fastest(), rate: 1.0, duration: plan.least() })
    }
}

impl Profile for SevenPhase {
    fn distance(&self) -> f64 {
        self.distance
    }

    fn duration(&self) -> f64 {
        self.duration
    }

    fn at(&self, t: f64) -> ProfilePoint {
        if t >= self.duration {
            return ProfilePoint { s: self.distance, v: 0.0, a: 0.0 };
        }
        if t < 0.0 {
            return ProfilePoint::default();
        }
        let point = self.motion.at(t * self.rate);
        ProfilePoint {
            s: point.position,
            v: point.velocity * self.rate,
            a: point.acceleration * self.rate * self.rate,
        }
    }

    fn stretched_to(self, duration: f64) -> Result<Self, ProfileError> {
        check_stretch(duration, self.duration)?;
        let rate = if duration > 0.0 { self.motion.duration() / duration } else { self.rate };
        Ok(SevenPhase { rate, duration, ..self })
    }
}
