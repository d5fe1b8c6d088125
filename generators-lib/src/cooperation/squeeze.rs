//! The law that turns internal wrenches into small displacements of the tools: an admittance.
//!
//! With `F` the internal part of the load on the tool, `Fd` the desired one, `K` the stiffness of the grasp, `a` the rate and
//! `m` the inertia of the law, and `T` the path time of the step, per axis of the tool's frame:
//!
//! ```text
//! v = [T a K^-1 (F - Fd) + m v'] / (T + m)          delta = delta' + v T
//! ```
//!
//! This is MRROC++'s law of force control, `Delta = [b (Fd - F) T^2 + b m_i Delta'] / (T + b m_i)`, with the reciprocal
//! damping `b = a / K`, the inertia `m_i = m / b` and the opposite sign of `F` (there the load on the environment).
//!
//! **Stability.** Displacing a grasp by `delta` changes the internal load on its tool by `-K delta`, projected on what is
//! internal, so that every mode of the internal force is the same loop, whatever the number of arms: `L(s) = k a e^(-sD) / (s (1 +
//! m s))`, with `k` the ratio of the true stiffness to `K` and `D` the delay from a demand to the reading that tells of it.
//! It crosses gain 1 at a frequency below `k a`, with a phase lag of less than `pi/2 + k a (D + m)`: stable for `k a (D + m) <
//! pi/2`. [`SqueezeLaw::new`] asks for `a (D + m) < 1`: then grasps may be half as stiff again as stated. A static
//! misplacement decays at the rate `a`.
//!
//! **Bounds.** A correction that would exceed its bounds of speed or travel is a fault, never cut off: internal forces that call
//! for more are no misplacement of some millimetres but a wrong sensor, a lost grasp or an obstacle.

use mrroc::pose::Wrench;
use mrroc::prelude::*;
use nalgebra::{Translation3, UnitQuaternion, Vector3};
use thiserror::Error;

use super::GraspStiffness;

/// How the law answers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SqueezeGains {
    /// Stiffness of a grasp.
    pub stiffness: GraspStiffness,
    /// Rate `a` at which a stress decays [1/s], finite, > 0.
    pub rate: f64,
    /// Inertia `m` \[s\], finite, >= 0: the time in which the correction's speed follows the force.
    pub inertia: f64,
}

/// What a correction must not exceed; all finite, > 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SqueezeBounds {
    /// Speed [m/s].
    pub speed: f64,
    /// Angular speed [rad/s].
    pub turning: f64,
    /// Distance from the rigid grasp \[m\].
    pub travel: f64,
    /// Angle from the rigid grasp \[rad\].
    pub angle: f64,
}

/// Why a law of squeeze control cannot be made.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum BadSqueeze {
    /// A number is out of its range.
    #[error(
        "{name} of the squeeze law is {value}, it must be finite and greater than 0 (inertia and delay: or 0)"
    )]
    OutOfRange {
        /// Which.
        name: &'static str,
        /// Its value, SI.
        value: f64,
    },
    /// The loop would have too little reserve: `rate * (delay + inertia)` must be less than 1.
    #[error("no reserve of stability: rate {rate} 1/s times delay and inertia {lag:.4} s is not below 1")]
    NoReserve {
        /// The rate [1/s].
        rate: f64,
        /// Delay and inertia \[s\].
        lag: f64,
    },
}

/// The law, without state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SqueezeLaw {
    gains: SqueezeGains,
    bounds: SqueezeBounds,
}

/// The correction of one arm.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Correction {
    travel: Vector3<f64>,
    angle: Vector3<f64>,
    speed: Vector3<f64>,
    turning: Vector3<f64>,
}

impl SqueezeLaw {
    /// The law for a `delay` \[s\] from a demand to the reading that tells of it, of all that lies between: the step itself,
    /// interpolation (one step), the drives' lag, the sensor's filter, its age.
    ///
    /// # Errors
    /// A number out of range, or too little reserve of stability.
    pub fn new(gains: SqueezeGains, bounds: SqueezeBounds, delay: f64) -> Result<Self, BadSqueeze> {
        let positive = [
            ("force stiffness", gains.stiffness.force),
            ("torque stiffness", gains.stiffness.torque),
            ("rate", gains.rate),
            ("speed bound", bounds.speed),
            ("turning bound", bounds.turning),
            ("travel bound", bounds.travel),
            ("angle bound", bounds.angle),
        ];
        for (name, value) in positive {
            if !(value.is_finite() && value > 0.0) {
                return Err(BadSqueeze::OutOfRange { name, value });
            }
        }
        for (name, value) in [("inertia", gains.inertia), ("delay", delay)] {
            if !(value.is_finite() && value >= 0.0) {
                return Err(BadSqueeze::OutOfRange { name, value });
            }
        }
        let lag = delay + gains.inertia;
        if gains.rate * lag >= 1.0 {
            return Err(BadSqueeze::NoReserve { rate: gains.rate, lag });
        }
        Ok(SqueezeLaw { gains, bounds })
    }

    /// Stiffness of a grasp, as the law has it.
    #[must_use]
    pub const fn stiffness(&self) -> GraspStiffness {
        self.gains.stiffness
    }

    /// The correction `X_EE'` of a tool after `dt` \[s\] more of path time, in which the internal load on it differs from the
    /// desired one by `excess`. With `dt = 0` it stays.
    ///
    /// # Errors
    /// A correction beyond its bounds, or an excess that is not finite.
    pub fn advance(&self, c: &mut Correction, excess: &Wrench, dt: f64) -> Result<Pose, Fault> {
        if !excess.is_finite() {
            return Err(Fault::thrown("a wrench at a grasp is not finite"));
        }
        let SqueezeGains { stiffness, rate, inertia } = self.gains;
        if dt > 0.0 {
            let law = |compliance: f64, force: Vector3<f64>, before: Vector3<f64>| {
                (force * (dt * rate * compliance) + before * inertia) / (dt + inertia)
            };
            c.speed = law(1.0 / stiffness.force, excess.force, c.speed);
            c.turning = law(1.0 / stiffness.torque, excess.torque, c.turning);
            c.travel += c.speed * dt;
            c.angle += c.turning * dt;
            self.check(c)?;
        }
        Ok(Pose::from_parts(Translation3::from(c.travel), UnitQuaternion::from_scaled_axis(c.angle)))
    }

    fn check(&self, c: &Correction) -> Result<(), Fault> {
        let SqueezeBounds { speed, turning, travel, angle } = self.bounds;
        for (what, actual, limit, unit) in [
            ("the internal force calls for too fast a correction", c.speed.norm(), speed, "m/s"),
            ("the internal torque calls for too fast a correction", c.turning.norm(), turning, "rad/s"),
            ("the internal force calls for too large a correction", c.travel.norm(), travel, "m"),
            ("the internal torque calls for too large a correction", c.angle.norm(), angle, "rad"),
        ] {
            if actual > limit {
                return Err(Fault::thrown(what).exceeds(actual, limit, unit));
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BOUNDS: SqueezeBounds = SqueezeBounds { speed: 0.1, turning: 1.0, travel: 0.01, angle: 0.1 };

    fn gains(rate: f64, inertia: f64) -> SqueezeGains {
        SqueezeGains { stiffness: GraspStiffness { force: 5e4, torque: 500.0 }, rate, inertia }
    }

    /// A grasp misplaced by 1 mm and 2 mrad, `k` times as stiff as stated, read `delay` steps late: what is left after `steps`,
    /// and the largest overshoot.
    fn relax(law: &SqueezeLaw, k: f64, delay: usize, steps: usize) -> (f64, f64) {
        let mut c = Correction::default();
        let mut past = vec![(1e-3, 2e-3); delay + 1];
        let mut left = 1.0_f64;
        let mut overshoot = 0.0_f64;
        for _ in 0..steps {
            let (travel, angle) = past[past.len() - 1 - delay];
            let load = Wrench::new(Vector3::x() * (5e4 * k * travel), Vector3::y() * (500.0 * k * angle));
            let pose = law.advance(&mut c, &load, 2e-3).expect("within the bounds");
            past.push((1e-3 - pose.translation.x, 2e-3 - pose.rotation.scaled_axis().y));
            let (travel, angle) = past[past.len() - 1];
            left = (travel / 1e-3).abs().max((angle / 2e-3).abs());
            overshoot = overshoot.max(-travel / 1e-3);
        }
        (left, overshoot)
    }

    #[test]
    fn a_misplacement_decays_at_the_rate() {
        let law = SqueezeLaw::new(gains(5.0, 0.0), BOUNDS, 2e-3).expect("reserve");
        // (1 - a T)^n.
        let (left, _) = relax(&law, 1.0, 0, 500);
        assert!((left - (1.0_f64 - 5.0 * 2e-3).powi(500)).abs() < 1e-12, "{left}");
    }

    #[test]
    fn whatever_the_law_accepts_is_stable_with_grasps_half_as_stiff_again() {
        for steps in [1, 5, 20, 50] {
            for share in [0.0, 0.3, 0.7] {
                let delay = f64::from(steps) * 2e-3;
                let lag = delay / (1.0 - share);
                let gains = gains(0.999 / lag, lag - delay);
                let wide = SqueezeBounds { speed: 10.0, turning: 10.0, travel: 1.0, angle: 1.0 };
                let law = SqueezeLaw::new(gains, wide, delay).expect("reserve");
                // The step itself is the first of the delay's steps.
                let (left, _) = relax(&law, 1.5, steps as usize - 1, 300 * steps as usize + 3000);
                assert!(left < 1e-3, "{steps} steps, inertia {share}: {left}");
            }
        }
    }

    #[test]
    fn a_law_without_reserve_is_refused() {
        let refused = SqueezeLaw::new(gains(10.0, 0.06), BOUNDS, 0.05);
        assert_eq!(refused, Err(BadSqueeze::NoReserve { rate: 10.0, lag: 0.11 }));
        let refused = SqueezeLaw::new(gains(f64::NAN, 0.0), BOUNDS, 0.0);
        assert!(matches!(refused, Err(BadSqueeze::OutOfRange { name: "rate", .. })));
    }

    #[test]
    fn a_correction_beyond_its_bounds_is_a_fault_and_none_is_made_at_standstill() {
        let law = SqueezeLaw::new(gains(5.0, 0.0), BOUNDS, 2e-3).expect("reserve");
        let mut c = Correction::default();
        // 5 /s * 1010 N / 5e4 N/m = 0.101 m/s.
        let load = Wrench::new(Vector3::x() * 1010.0, Vector3::zeros());
        let fault = law.advance(&mut c, &load, 2e-3).expect_err("too fast");
        let excess = fault.excess().expect("a bound");
        assert!((excess.actual - 0.101).abs() < 1e-12 && excess.limit == 0.1 && excess.unit == "m/s");
        let mut c = Correction::default();
        assert_eq!(law.advance(&mut c, &load, 0.0).expect("nothing moves"), Pose::identity());
    }

    #[test]
    fn the_law_is_that_of_mrrocpp() {
        // facts: Delta = [(b (Fd - F)) T^2 + b m Delta'] / (T + b m), F the load on the environment.
        let b = 2e-4;
        let m = 250.0;
        let t = 2e-3;
        let law = SqueezeLaw::new(gains(b * 5e4, b * m), BOUNDS, 0.0).expect("reserve");
        let mut c = Correction::default();
        let mut delta = 0.0;
        let mut travel = 0.0;
        for i in 0..50 {
            let force = 10.0 * f64::from(i % 7) - 20.0;
            let pose = law.advance(&mut c, &Wrench::new(Vector3::z() * force, Vector3::zeros()), t);
            delta = (b * force * t * t + b * m * delta) / (t + b * m);
            travel += delta;
            assert!((pose.expect("small").translation.z - travel).abs() < 1e-15);
        }
    }
}
