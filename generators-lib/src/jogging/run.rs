//! Along a path, and to rest on it at any time.

use mrroc::prelude::*;

use super::Ahead;
use crate::jerk::{AxisLimits, AxisPlan, AxisState, AxisTarget};

/// How far along a path, and how fast.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Run {
    at: AxisState,
}

impl Run {
    /// How much of the path is behind.
    #[must_use]
    pub const fn at(&self) -> f64 {
        self.at.position
    }

    /// Whether it stands.
    #[must_use]
    pub fn rests(&self) -> bool {
        self.at.velocity == 0.0 && self.at.acceleration == 0.0
    }

    /// Goes on for `dt` \[s\] of path time, > 0: at up to `share` of the largest speed, or to rest where it is `None`; never
    /// farther than the path is clear.
    ///
    /// # Errors
    /// Numbers of which no motion can be made.
    pub fn go<R: Robot>(&mut self, ahead: &Ahead<R>, share: Option<f64>, dt: f64) -> Result<(), Fault> {
        let (acceleration, jerk) = ahead.limits();
        let position = match share {
            Some(_) => ahead.clear(),
            None => (self.at.position + self.stopping(acceleration, jerk)).min(ahead.clear()),
        };
        // To rest from a speed that is no longer allowed it goes as from one that is.
        let speed = (share.unwrap_or(1.0) * ahead.speed()).max(f64::MIN_POSITIVE);
        let limits = AxisLimits::symmetric(speed, acceleration, jerk);
        let target = AxisTarget { position, ..AxisTarget::default() };
        let plan =
            AxisPlan::new(&self.at, &target, &limits).map_err(|why| Fault::thrown(&why.to_string()))?;
        let next = if plan.least() <= dt { None } else { Some(plan.fastest().at(dt)) };
        self.at = next.map_or(AxisState { position, velocity: 0.0, acceleration: 0.0 }, |next| AxisState {
            position: next.position,
            velocity: next.velocity,
            acceleration: next.acceleration,
        });
        Ok(())
    }

    /// How far it goes until it rests.
    ///
    /// ```text
    /// p = min(A, sqrt(J v + a² / 2)),   from a to -p by the jerk, held, and back to 0 by the jerk
    /// ```
    fn stopping(&self, most: f64, jerk: f64) -> f64 {
        let (v, a) = (self.at.velocity, self.at.acceleration);
        let peak = most.min((jerk * v + 0.5 * a * a).max(0.0).sqrt());
        // One that slows down harder already comes to rest by easing off.
        let peak = peak.max(-a);
        let last = peak * peak / (2.0 * jerk);
        let easing = (a + peak).max(0.0) / jerk;
        let held = v + easing * (a - 0.5 * easing * jerk) - last;
        let held = if peak > 0.0 { (held / peak).max(0.0) } else { 0.0 };
        let (mut distance, mut v, mut a) = (0.0, v, a);
        for (time, jerk) in [(easing, -jerk), (held, 0.0), (peak / jerk, jerk)] {
            distance += time * (v + time * (0.5 * a + time * jerk / 6.0));
            v += time * (a + 0.5 * time * jerk);
            a += time * jerk;
        }
        distance.max(0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// Against the motion itself, in small steps: jerk down to the peak, held, and back.
        #[test]
        fn the_distance_to_rest_is_that_of_the_motion_that_stops(v in 0.0..1.0_f64, share in -0.9..1.0_f64, most in 0.2..2.0_f64, jerk in 1.0..20.0_f64) {
            // No acceleration that would turn it round before it eases off.
            let most_back = (2.0 * jerk * v).sqrt().min(most);
            let a = if share < 0.0 { share * most_back } else { share * most };
            let run = Run { at: AxisState { position: 0.0, velocity: v, acceleration: a } };
            let distance = run.stopping(most, jerk);
            let limits = AxisLimits::symmetric(100.0, most, jerk);
            let target = AxisTarget { position: distance, ..AxisTarget::default() };
            let plan = AxisPlan::new(&run.at, &target, &limits).expect("a plan");
            // The fastest motion there never turns round: it stops as soon as it can.
            let peaks = plan.fastest().peaks();
            prop_assert!(peaks.velocity.1 > -1e-6, "{:?} {distance}", peaks);
            prop_assert!(peaks.velocity.0 <= v + a.max(0.0).powi(2) / (2.0 * jerk) + 1e-6, "{:?} {distance}", peaks);
        }
    }
}
