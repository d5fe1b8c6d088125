//! One polynomial from end to end.
//!
//! ```text
//! x = t / T     cubic   s = D (3 x^2 - 2 x^3)             peaks  3 D / 2 T,  6 D / T^2
//!               quintic s = D (10 x^3 - 15 x^4 + 6 x^5)   peaks 15 D / 8 T, 10 D / (sqrt 3 T^2), 60 D / T^3
//! ```

use super::{JerkLimits, Profile, ProfileError, ProfileLimits, ProfilePoint, check_stretch, validate};

/// The cubic with no velocity at its ends; its acceleration is a falling line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cubic {
    distance: f64,
    duration: f64,
}

/// The quintic with neither velocity nor acceleration at its ends: smoothest, a tenth to a third slower than the fastest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quintic {
    distance: f64,
    duration: f64,
}

/// A duration that must be a number.
fn checked(distance: f64, duration: f64) -> Result<f64, ProfileError> {
    if duration.is_finite() { Ok(duration) } else { Err(ProfileError::Precision(distance)) }
}

impl Cubic {
    /// The fastest over `distance` \[units\] within `limits`.
    ///
    /// # Errors
    /// A distance that is negative or not finite, or a limit that is not positive.
    pub fn new(distance: f64, limits: ProfileLimits) -> Result<Self, ProfileError> {
        let ProfileLimits { velocity, acceleration } = limits;
        validate(distance, velocity, acceleration, 1.0)?;
        let duration = (1.5 * distance / velocity).max((6.0 * distance / acceleration).sqrt());
        Ok(Cubic { distance, duration: checked(distance, duration)? })
    }
}

impl Quintic {
    /// The fastest over `distance` \[units\] within `limits`, of which any may be infinite, but not all.
    ///
    /// # Errors
    /// A distance that is negative or not finite, or a limit that is not positive.
    pub fn new(distance: f64, limits: JerkLimits) -> Result<Self, ProfileError> {
        let JerkLimits { velocity, acceleration, jerk } = limits;
        validate(distance, velocity, acceleration, jerk)?;
        let duration = (1.875 * distance / velocity)
            .max((10.0 / 3.0_f64.sqrt() * distance / acceleration).sqrt())
            .max((60.0 * distance / jerk).cbrt());
        Ok(Quintic { distance, duration: checked(distance, duration)? })
    }
}

impl Profile for Cubic {
    fn distance(&self) -> f64 {
        self.distance
    }

    fn duration(&self) -> f64 {
        self.duration
    }

    fn at(&self, t: f64) -> ProfilePoint {
        let d = self.distance;
        let i = 1.0 / self.duration;
        let x = t * i;
        if t >= self.duration {
            return ProfilePoint { s: d, v: 0.0, a: 0.0 };
        }
        if x < 0.0 {
            return ProfilePoint::default();
        }
        ProfilePoint {
            s: d * x * x * (3.0 - 2.0 * x),
            v: 6.0 * d * i * x * (1.0 - x),
            a: 6.0 * d * i * i * (1.0 - 2.0 * x),
        }
    }

    fn stretched_to(self, duration: f64) -> Result<Self, ProfileError> {
        check_stretch(duration, self.duration)?;
        Ok(Cubic { duration, ..self })
    }
}

impl Profile for Quintic {
    fn distance(&self) -> f64 {
        self.distance
    }

    fn duration(&self) -> f64 {
        self.duration
    }

    fn at(&self, t: f64) -> ProfilePoint {
        let d = self.distance;
        let i = 1.0 / self.duration;
        let x = t * i;
        if t >= self.duration {
            return ProfilePoint { s: d, v: 0.0, a: 0.0 };
        }
        if x < 0.0 {
            return ProfilePoint::default();
        }
        let y = 1.0 - x;
        ProfilePoint {
            s: d * x * x * x * (10.0 + x * (6.0 * x - 15.0)),
            v: 30.0 * d * i * x * x * y * y,
            a: 60.0 * d * i * i * x * y * (y - x),
        }
    }

    fn stretched_to(self, duration: f64) -> Result<Self, ProfileError> {
        check_stretch(duration, self.duration)?;
        Ok(Quintic { duration, ..self })
    }
}
