//! A measured pose as a reference: followed with a first-order lag, so that encoders' counts do not become accelerations.
//!
//! ```text
//! X' = X Exp(dt / (lag + dt) Log(X^-1 X_measured))        position and orientation apart
//! ```

use mrroc::pose::Pose;
use nalgebra::{Translation3, UnitQuaternion};

/// A pose that follows another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Smoothed {
    pose: Pose,
    lag: f64,
}

impl Smoothed {
    /// At `pose`, to follow with a time constant `lag` \[s\], >= 0; 0 follows at once.
    #[must_use]
    pub const fn new(pose: Pose, lag: f64) -> Self {
        Smoothed { pose, lag }
    }

    /// The pose after `dt` \[s\] more of path time in which the other was at `reference`.
    pub fn follow(&mut self, reference: &Pose, dt: f64) -> Pose {
        if dt > 0.0 {
            let share = dt / (self.lag + dt);
            let from = self.pose.translation.vector;
            let to = reference.translation.vector;
            let turn = (self.pose.rotation.inverse() * reference.rotation).scaled_axis();
            self.pose = Pose::from_parts(
                Translation3::from(from + (to - from) * share),
                self.pose.rotation * UnitQuaternion::from_scaled_axis(turn * share),
            );
        }
        self.pose
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;

    #[test]
    fn without_lag_it_is_the_reference_and_with_it_a_steady_motion_is_followed_one_lag_behind() {
        let at = |t: f64| Pose::new(Vector3::new(0.1 * t, 0.0, 0.0), Vector3::z() * 0.3 * t);
        let mut plain = Smoothed::new(at(0.0), 0.0);
        let mut lagging = Smoothed::new(at(0.0), 0.05);
        for i in 1..=1000 {
            let t = f64::from(i) * 1e-3;
            let error = plain.follow(&at(t), 1e-3).inverse() * at(t);
            assert!(error.translation.vector.norm() < 1e-15 && error.rotation.angle() < 1e-7);
            let late = lagging.follow(&at(t), 1e-3);
            if i == 1000 {
                assert!((late.translation.x - 0.1 * (1.0 - 0.05)).abs() < 1e-9);
                assert!((late.rotation.angle() - 0.3 * (1.0 - 0.05)).abs() < 1e-8);
            }
        }
        assert_eq!(lagging.follow(&at(5.0), 0.0), lagging.follow(&at(7.0), 0.0));
    }
}
