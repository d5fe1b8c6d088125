//! The trapezoidal profile, or the triangular one where the distance is short: the fastest without a limit of jerk.
//!
//! ```text
//! v_p = min(V, sqrt(A D))      peak velocity
//! t_a = v_p / A                duration of either ramp
//! T   = D / v_p + t_a          duration (D > 0)
//! ```
//!
//! Source: Biagiotti and Melchiorri, *Trajectory Planning for Automatic Machines and Robots*, section 3.2.

use super::{Profile, ProfileError, ProfileLimits, ProfilePoint, whole_steps};

/// A trapezoidal (or triangular) rest-to-rest profile; immutable.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Trapezoid {
    distance: f64,
    peak: f64,
    acceleration: f64,
    ramp: f64,
    duration: f64,
}

impl Trapezoid {
    /// The fastest profile over `distance` \[units\] within `limits`.
    ///
    /// # Errors
    /// A distance that is negative or not finite, or a limit that is not positive.
    pub fn new(distance: f64, limits: ProfileLimits) -> Result<Self, ProfileError> {
        let ProfileLimits { velocity, acceleration } = limits;
        if !(distance.is_finite() && distance >= 0.0) {
            return Err(ProfileError::Distance(distance));
        }
        if velocity.is_nan() || velocity <= 0.0 {
            return Err(ProfileError::Velocity(velocity));
        }
        if !(acceleration.is_finite() && acceleration > 0.0) {
            return Err(ProfileError::Acceleration(acceleration));
        }
        let peak = velocity.min((acceleration * distance).sqrt());
        let ramp = peak / acceleration;
        let duration = if peak > 0.0 { distance / peak + ramp } else { 0.0 };
        Ok(Self { distance, peak, acceleration, ramp, duration })
    }

    /// The fastest profile over `distance` \[units\] within an `acceleration` [units/s^2] alone: a triangle of velocity,
    /// `T = 2 sqrt(D / A)`.
    ///
    /// # Errors
    /// A distance that is negative or not finite, or an acceleration that is not positive and finite.
    pub fn triangular(distance: f64, acceleration: f64) -> Result<Self, ProfileError> {
        Self::new(distance, ProfileLimits { velocity: f64::INFINITY, acceleration })
    }

    /// The same motion in exactly `duration` \[s\], slower: with `k = duration / T`, velocities shrink by `k` and
    /// accelerations by `k^2`, so no limit is broken. Synchronises axes and arms.
    ///
    /// # Errors
    /// A duration shorter than this profile's (or not finite).
    pub fn stretched_to(self, duration: f64) -> Result<Self, ProfileError> {
        if !(duration.is_finite() && duration >= self.duration) {
            return Err(ProfileError::Duration { asked: duration, least: self.duration });
        }
        if self.duration == 0.0 {
            return Ok(self);
        }
        let k = duration / self.duration;
        Ok(Self {
            distance: self.distance,
            peak: self.peak / k,
            acceleration: self.acceleration / (k * k),
            ramp: self.ramp * k,
            duration,
        })
    }

    /// The duration rounded up to a whole number of steps of `dt` \[s\], > 0, by [`Self::stretched_to`]: the end then
    /// falls on a step. A `dt` that is not positive leaves the profile as it is.
    #[must_use]
    pub fn in_whole_steps(self, dt: f64) -> Self {
        self.stretched_to(whole_steps(self.duration, dt)).unwrap_or(self)
    }

    /// Distance `D` \[units\].
    #[must_use]
    pub fn distance(&self) -> f64 {
        self.distance
    }

    /// Duration `T` \[s\].
    #[must_use]
    pub fn duration(&self) -> f64 {
        self.duration
    }

    /// Peak velocity [units/s].
    #[must_use]
    pub fn peak(&self) -> f64 {
        self.peak
    }

    /// The profile at path time `t` \[s\]. Before 0 it rests at 0, from [`Self::duration`] on at the exact distance.
    #[must_use]
    pub fn at(&self, t: f64) -> ProfilePoint {
        if t >= self.duration {
            return self.end();
        }
        let a = self.acceleration;
        if t < self.ramp {
            let t = t.max(0.0);
            return ProfilePoint { s: 0.5 * a * t * t, v: a * t, a };
        }
        let left = self.duration - t;
        if left <= self.ramp {
            return ProfilePoint { s: self.distance - 0.5 * a * left * left, v: a * left, a: -a };
        }
        ProfilePoint { s: self.peak * (t - 0.5 * self.ramp), v: self.peak, a: 0.0 }
    }

    fn end(&self) -> ProfilePoint {
        ProfilePoint { s: self.distance, v: 0.0, a: 0.0 }
    }
}

impl Profile for Trapezoid {
    fn distance(&self) -> f64 {
        self.distance
    }

    fn duration(&self) -> f64 {
        self.duration
    }

    fn at(&self, t: f64) -> ProfilePoint {
        Trapezoid::at(self, t)
    }

    fn stretched_to(self, duration: f64) -> Result<Self, ProfileError> {
        Trapezoid::stretched_to(self, duration)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn trapezoid(distance: f64, velocity: f64, acceleration: f64) -> Trapezoid {
        Trapezoid::new(distance, ProfileLimits { velocity, acceleration }).unwrap()
    }

    /// Closed forms T = D/V + V/A, or 2 sqrt(D/A) where V is not reached.
    #[test]
    fn durations_equal_the_closed_forms() {
        assert!((trapezoid(10.0, 2.0, 1.0).duration() - 7.0).abs() < 1e-12);
        assert!((trapezoid(8.0, 2.0, 1.0).duration() - 6.0).abs() < 1e-12);
        assert!((trapezoid(3.0, 2.0, 1.0).duration() - 3.464_101_615_138).abs() < 1e-11);
    }

    /// Corke's robotics toolbox: `trapezoidal(0, 1, 9)` has v = 0.1875 over t = 0..8, hence t_b = 8/3 s.
    #[test]
    fn positions_equal_the_robotics_toolbox() {
        let profile = trapezoid(1.0, 0.1875, 0.1875 / (8.0 / 3.0));
        assert!((profile.duration() - 8.0).abs() < 1e-12);
        for (t, s) in [0.0, 0.035_156_25, 0.140_625, 0.3125, 0.5].into_iter().enumerate() {
            assert!((profile.at(t as f64).s - s).abs() < 1e-12, "t = {t}");
        }
    }

    #[test]
    fn the_exact_end_is_emitted_once_and_then_none() {
        for distance in [0.0, 1e-12, 0.7, 3.0] {
            let mut cursor = trapezoid(distance, 0.4, 1.3).cursor();
            let mut last = None;
            while let Some(point) = cursor.advance(0.001) {
                last = Some(point);
            }
            assert_eq!(last, Some(ProfilePoint { s: distance, v: 0.0, a: 0.0 }));
            assert_eq!(cursor.advance(0.001), None);
        }
    }

    #[test]
    fn a_profile_in_whole_steps_ends_on_a_step() {
        for distance in [0.1, 0.33, 1.0, 2.0] {
            let fast = trapezoid(distance, 0.7, 1.9);
            let profile = fast.in_whole_steps(0.002);
            let steps = profile.duration() / 0.002;
            assert!((steps - steps.round()).abs() < 1e-9);
            assert!(profile.duration() < fast.duration() + 0.002);
            let mut cursor = profile.cursor();
            assert_eq!(std::iter::from_fn(|| cursor.advance(0.002)).count(), steps.round() as usize);
        }
        // Already whole: nothing changes.
        assert!((trapezoid(10.0, 2.0, 1.0).in_whole_steps(0.001).duration() - 7.0).abs() < 1e-12);
    }

    #[test]
    fn no_time_no_motion_and_impossible_limits_are_refused() {
        let mut cursor = trapezoid(1.0, 1.0, 1.0).cursor();
        let here = cursor.advance(0.5);
        assert_eq!(cursor.advance(0.0), here);
        let limits = |velocity, acceleration| ProfileLimits { velocity, acceleration };
        assert!(Trapezoid::new(f64::NAN, limits(1.0, 1.0)).is_err());
        assert!(Trapezoid::new(-1.0, limits(1.0, 1.0)).is_err());
        assert!(Trapezoid::new(1.0, limits(0.0, 1.0)).is_err());
        assert!(Trapezoid::new(1.0, limits(1.0, f64::NAN)).is_err());
        assert!(trapezoid(1.0, 1.0, 1.0).stretched_to(0.1).is_err());
    }

    proptest! {
        #[test]
        fn finite_differences_stay_within_the_limits(d in 1e-3..10.0f64, v in 0.05..3.0f64, a in 0.1..20.0f64) {
            let profile = trapezoid(d, v, a).in_whole_steps(1e-3);
            let h = profile.duration() / 1777.0;
            let s = |i: i32| profile.at(f64::from(i) * h).s;
            for i in -2..1780 {
                let velocity = (s(i + 1) - s(i)) / h;
                let acceleration = (s(i + 1) - 2.0 * s(i) + s(i - 1)) / (h * h);
                prop_assert!(velocity >= -1e-9 && velocity <= v * (1.0 + 1e-9));
                prop_assert!(acceleration.abs() <= a * (1.0 + 1e-6) + 1e-14 * d / (h * h));
            }
        }

        #[test]
        fn a_profile_run_backwards_is_itself(d in 0.0..10.0f64, v in 0.05..3.0f64, a in 0.1..20.0f64, x in 0.0..1.0f64) {
            let profile = trapezoid(d, v, a);
            let there = profile.at(x * profile.duration());
            let back = profile.at((1.0 - x) * profile.duration());
            prop_assert!((there.s + back.s - d).abs() < 1e-9 * (1.0 + d));
            prop_assert!((there.v - back.v).abs() < 1e-9 * (1.0 + v));
        }

        #[test]
        fn a_changing_feed_rate_visits_the_same_profile(steps in proptest::collection::vec(0.0..0.02f64, 1..200)) {
            let profile = trapezoid(0.8, 0.5, 1.0);
            let mut cursor = profile.cursor();
            for dt in steps {
                if let Some(point) = cursor.advance(dt) {
                    prop_assert!((point.s - profile.at(cursor.time()).s).abs() < 1e-12);
                }
            }
        }
    }
}
