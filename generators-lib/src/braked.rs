//! A motion that is braked on its path, by taking its path time away.

/// The share of path time that a motion still gets while it is braked within a given time. Its slope is a trapezoid of thirds, so that
/// neither the velocity nor the acceleration has a step. With `x` the part of the time `T` that has passed,
///
/// ```text
/// s(x) = 1 - 9/4 x^2                    x <= 1/3
///        5/4 - 3/2 x              1/3 < x <= 2/3         largest |s'| = 3/2 / T
///        9/4 (1 - x)^2            2/3 < x <= 1           largest |s''| = 9/2 / T^2
/// ```
///
/// A motion at a constant speed `v` is braked over `v T / 2` by at most `3/2 v / T`, with a jerk of at most `9/2 v / T^2`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Braked {
    /// See `T` \[s\].
    within: f64,
    /// How much of it has passed \[s\].
    passed: f64,
}

impl Braked {
    /// Whether a motion can be braked within this time \[s\].
    pub fn is_possible(within: f64) -> bool {
        within.is_finite() && within > 0.0
    }

    /// Begins to brake a motion within this time \[s\].
    pub const fn within(within: f64) -> Self {
        Braked { within, passed: 0.0 }
    }

    /// Whether it stands.
    pub fn stands(&self) -> bool {
        self.passed >= self.within
    }

    /// The share of path time in the next step, of which `dt` \[s\] is path time.
    pub fn share(&mut self, dt: f64) -> f64 {
        self.passed += dt;
        let x = (self.passed / self.within).min(1.0);
        let left = 1.0 - x;
        if 3.0 * x <= 1.0 {
            1.0 - 2.25 * x * x
        } else if 3.0 * left >= 1.0 {
            1.25 - 1.5 * x
        } else {
            2.25 * left * left
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_motion_is_braked_over_half_its_distance_within_a_deceleration_and_a_jerk() {
        for (within, dt) in [(0.1, 1e-3), (0.06, 4e-3), (0.37, 2e-3), (1.0, 3e-3), (0.05, 7e-3)] {
            let mut braked = Braked::within(within);
            let mut shares = vec![1.0; 2];
            while !braked.stands() {
                shares.push(braked.share(dt));
            }
            shares.extend([0.0; 2]);
            // It stands after the time, or within the step after it.
            let steps = shares.len() - 4;
            assert!((within..within + dt + 1e-9).contains(&(steps as f64 * dt)), "{steps} of {within}, {dt}");
            assert_eq!(shares[steps + 1], 0.0);
            let slope = shares.windows(2).map(|s| (s[1] - s[0]) / dt).fold(0.0, f64::min);
            assert!(slope >= -1.5 / within - 1e-9, "{slope} of {within}, {dt}");
            let bend = shares.windows(3).map(|s| (s[2] - 2.0 * s[1] + s[0]).abs() / dt.powi(2));
            let bend = bend.fold(0.0, f64::max);
            assert!(bend <= 4.5 / within.powi(2) + 1e-6, "{bend} of {within}, {dt}");
            // The distance is half of what the speed makes of the time; a sum over steps is less by half a step.
            let distance: f64 = shares[2..].iter().sum::<f64>() * dt;
            assert!(
                (distance + 0.5 * dt - 0.5 * within).abs() < 0.02 * within.max(dt),
                "{distance} of {within}, {dt}"
            );
        }
    }
}
