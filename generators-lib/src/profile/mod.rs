//! Rest-to-rest profiles of a path scalar.
//!
//! In: a distance `D` and the limits of velocity `V`, acceleration `A` and jerk `J` along it. Out: the path scalar and its
//! first two derivatives over *path time*, which an operator's feed rate stretches or stops.
//!
//! | profile | limits | duration | steps in |
//! |---|---|---|---|
//! | [`Rectangular`] | V | `D / V` | velocity |
//! | [`Trapezoid`] | V, A | `D / V + V / A`, or `2 sqrt(D / A)` as a triangle | acceleration |
//! | [`Cubic`] | V, A | `max(3 D / 2 V, sqrt(6 D / A))` | acceleration |
//! | [`Quintic`] | V, A, J | `max(15 D / 8 V, sqrt(10 D / A sqrt 3), cbrt(60 D / J))` | jerk |
//! | [`SevenPhase`] | V, A, J | the least | jerk |
//!
//! Motion from and to other states, on many axes: [`jerk`](crate::jerk). Source: Biagiotti and Melchiorri, *Trajectory
//! Planning for Automatic Machines and Robots*, chapters 2 and 3.

mod cursor;
mod polynomial;
mod rectangular;
mod seven_phase;
mod trapezoid;

pub use cursor::ProfileCursor;
pub use polynomial::{Cubic, Quintic};
pub use rectangular::Rectangular;
pub use seven_phase::{JerkLimits, SevenPhase};
pub use trapezoid::Trapezoid;

use thiserror::Error;

/// Limits of a path scalar's rate of change.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProfileLimits {
    /// Largest velocity [units/s], > 0.
    pub velocity: f64,
    /// Largest acceleration and deceleration [units/s^2], finite, > 0.
    pub acceleration: f64,
}

/// Why a profile cannot be made.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum ProfileError {
    /// The distance is negative, infinite or not a number.
    #[error("profile distance {0} must be finite and not negative")]
    Distance(f64),
    /// The velocity limit is not positive.
    #[error("profile velocity limit {0} must be greater than 0")]
    Velocity(f64),
    /// The acceleration limit is not positive or not finite.
    #[error("profile acceleration limit {0} must be finite and greater than 0")]
    Acceleration(f64),
    /// The jerk limit is not positive or not finite.
    #[error("profile jerk limit {0} must be finite and greater than 0")]
    Jerk(f64),
    /// The numbers are too many orders of magnitude apart.
    #[error("profile of distance {0}: its numbers are too many orders of magnitude apart")]
    Precision(f64),
    /// A duration was asked for that would need more than the limits allow.
    #[error("profile duration {asked} s is shorter than the least possible, {least} s")]
    Duration {
        /// Duration asked for \[s\].
        asked: f64,
        /// Shortest duration within the limits \[s\].
        least: f64,
    },
}

/// Path scalar and its derivatives at one instant of path time.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ProfilePoint {
    /// Path scalar, from 0 to the profile's distance \[units\].
    pub s: f64,
    /// Its velocity [units/s], >= 0.
    pub v: f64,
    /// Its acceleration [units/s^2]; at a corner of the profile, that of the later phase.
    pub a: f64,
}

/// A motion of a path scalar from 0 to a distance, over path time; immutable. From rest to rest, unless it says otherwise.
pub trait Profile: Sized {
    /// Distance \[units\], >= 0.
    fn distance(&self) -> f64;

    /// Duration \[s\], >= 0.
    fn duration(&self) -> f64;

    /// The profile at path time `t` \[s\]. Before 0 it is at 0, from the duration on at the exact distance; at rest there.
    fn at(&self, t: f64) -> ProfilePoint;

    /// The same motion in exactly `duration` \[s\], slower: velocities shrink by `k = duration / T`, accelerations by
    /// `k^2`, jerks by `k^3`, so no limit is broken.
    ///
    /// # Errors
    /// A duration shorter than this profile's (or not finite).
    fn stretched_to(self, duration: f64) -> Result<Self, ProfileError>;

    /// A cursor at the start of this profile.
    #[must_use]
    fn cursor(self) -> ProfileCursor<Self> {
        ProfileCursor::new(self)
    }
}

/// `duration` rounded up to a whole number of steps of `dt` \[s\]; as it is where `dt` is not positive.
pub(crate) fn whole_steps(duration: f64, dt: f64) -> f64 {
    // A duration that is a whole number of steps, up to rounding, must not gain one.
    if dt > 0.0 { ((duration / dt - 1e-9).ceil() * dt).max(duration) } else { duration }
}

/// A distance and limits of which each is a number, and positive where it must be.
fn validate(distance: f64, velocity: f64, acceleration: f64, jerk: f64) -> Result<(), ProfileError> {
    let positive = |x: f64| x > 0.0;
    if !(distance.is_finite() && distance >= 0.0) {
        return Err(ProfileError::Distance(distance));
    }
    if !positive(velocity) {
        return Err(ProfileError::Velocity(velocity));
    }
    if !positive(acceleration) {
        return Err(ProfileError::Acceleration(acceleration));
    }
    if !positive(jerk) {
        return Err(ProfileError::Jerk(jerk));
    }
    Ok(())
}

/// What a longer duration makes of a shorter one, if it is one.
pub(crate) fn check_stretch(asked: f64, least: f64) -> Result<(), ProfileError> {
    if asked.is_finite() && asked >= least { Ok(()) } else { Err(ProfileError::Duration { asked, least }) }
}
