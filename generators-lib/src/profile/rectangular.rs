//! Constant velocity from the first instant to the last: where the acceleration does not matter.

use super::{Profile, ProfileError, ProfilePoint, check_stretch, validate};

/// A profile of constant velocity, `T = D / V`. Its acceleration has no bound: for scalars that drive no mass.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rectangular {
    distance: f64,
    duration: f64,
}

impl Rectangular {
    /// Over `distance` \[units\] at `velocity` [units/s], > 0.
    ///
    /// # Errors
    /// A distance that is negative or not finite, or a velocity that is not positive.
    pub fn new(distance: f64, velocity: f64) -> Result<Self, ProfileError> {
        validate(distance, velocity, 1.0, 1.0)?;
        let duration = distance / velocity;
        if !duration.is_finite() {
            return Err(ProfileError::Precision(distance));
        }
        Ok(Rectangular { distance, duration })
    }
}

impl Profile for Rectangular {
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
        let v = self.distance / self.duration;
        if t < 0.0 { ProfilePoint::default() } else { ProfilePoint { s: v * t, v, a: 0.0 } }
    }

    fn stretched_to(self, duration: f64) -> Result<Self, ProfileError> {
        check_stretch(duration, self.duration)?;
        Ok(Rectangular { duration, ..self })
    }
}
