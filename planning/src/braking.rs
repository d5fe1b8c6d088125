//! How one joint comes to rest in a fault stop, over time.
//!
//! In: its velocity and acceleration when it begins to brake, and its limits. Out: a [`Braking`], which tells how far it is after a time.
//!
//! Without a limit of jerk all joints of a robot brake evenly for the same time. With one each joint brakes by itself, as fast as its
//! limits allow: its acceleration goes to `-p`, stays there, and goes back to 0. `p` is the limit of acceleration `A`, or less where
//! `p^2 = j v + a^2 / 2` is. Robots brake in steps, which is never farther than this.

/// A part of a motion with constant jerk.
#[derive(Clone, Copy, Debug, Default)]
struct Phase {
    /// How long it lasts \[s\].
    time: f64,
    /// Its acceleration at its beginning [rad/s² or m/s²].
    acceleration: f64,
    /// Its jerk [rad/s³ or m/s³].
    jerk: f64,
}

/// The motion of a joint until it stands.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Braking {
    velocity: f64,
    phases: [Phase; 3],
}

impl Braking {
    /// Evenly from `velocity` [rad/s or m/s] to rest in `time` \[s\], >= 0.
    pub(crate) fn even(velocity: f64, time: f64) -> Self {
        let acceleration = if time > 0.0 { -velocity / time } else { 0.0 };
        let phases = [Phase { time, acceleration, jerk: 0.0 }, Phase::default(), Phase::default()];
        Braking { velocity, phases }
    }

    /// From `velocity` and `acceleration`, within limits of acceleration and jerk, each > 0.
    pub(crate) fn with_jerk(velocity: f64, acceleration: f64, limit: f64, jerk: f64) -> Self {
        // Where it would go if the acceleration did no more than fade.
        let fades_to = velocity + 0.5 * acceleration * acceleration.abs() / jerk;
        let side = if fades_to < 0.0 { -1.0 } else { 1.0 };
        let (v, a) = (side * velocity, side * acceleration);
        let unlimited = (0.5 * a * a + v * jerk).max(0.0).sqrt();
        let peak = unlimited.min(limit);
        // An acceleration beyond the limit is none of a plan.
        let peak = peak.max(-a);
        let hold = ((v + 0.5 * a * a / jerk - peak * peak / jerk) / peak.max(f64::MIN_POSITIVE)).max(0.0);
        let phase = |time, a: f64, j: f64| Phase { time, acceleration: side * a, jerk: side * j };
        let phases =
            [phase((a + peak) / jerk, a, -jerk), phase(hold, -peak, 0.0), phase(peak / jerk, -peak, jerk)];
        Braking { velocity, phases }
    }

    /// How long it lasts \[s\].
    pub(crate) fn duration(&self) -> f64 {
        self.phases.iter().map(|phase| phase.time).sum()
    }

    /// How far the joint is from where it began to brake after `time` \[s\], >= 0 [rad or m]; behind the end it stands.
    pub(crate) fn at(&self, time: f64) -> f64 {
        let (mut travel, mut v, mut left) = (0.0, self.velocity, time);
        for Phase { time, acceleration: a, jerk } in self.phases {
            let t = left.min(time);
            travel += t * (v + t * (0.5 * a + t * jerk / 6.0));
            v += t * (a + 0.5 * t * jerk);
            left -= t;
        }
        travel
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use mrroc::random::Random;
    use mrroc_robots::clearance::braking_distance;

    #[test]
    fn a_joint_with_a_limit_of_jerk_stops_within_its_limits_and_not_beyond_the_bound_of_the_proof() {
        let (limit, jerk) = (8.0, 400.0);
        let mut random = Random::seeded(7);
        for _ in 0..2000 {
            let (v, a) = (random.within(3.0), random.within(limit));
            let braking = Braking::with_jerk(v, a, limit, jerk);
            let h = 1e-4;
            let at = |k: i32| braking.at(h * f64::from(k));
            let last = (braking.duration() / h) as i32 + 4;
            let accelerations: Vec<f64> =
                (1..last).map(|k| (at(k + 1) - 2.0 * at(k) + at(k - 1)) / (h * h)).collect();
            assert!(accelerations.iter().all(|a| a.abs() <= limit + 1e-3), "from {v}, {a}");
            assert!(
                accelerations.windows(2).all(|a| (a[1] - a[0]).abs() <= jerk * h + 1e-3),
                "from {v}, {a}"
            );
            // The first difference is that of the velocity that it has.
            assert!(((at(1) - at(0)) / h - v).abs() < limit * h, "from {v}, {a}");
            assert!((at(last) - at(last - 2)).abs() < 1e-12, "from {v}, {a}: it stands");
            assert!(at(last).abs() <= braking_distance(v.abs(), limit, jerk), "from {v}, {a}");
        }
    }

    #[test]
    fn stops_from_a_steady_speed_are_as_long_as_their_equations_say() {
        // Acceleration from 0 to 0 with and without the limit in between.
        let long = Braking::with_jerk(2.0, 0.0, 8.0, 400.0);
        assert!((long.duration() - (2.0 / 8.0 + 8.0 / 400.0)).abs() < 1e-14);
        assert!((long.at(9.0) - 0.5 * 2.0 * (2.0 / 8.0 + 8.0 / 400.0)).abs() < 1e-14);
        let short = Braking::with_jerk(-0.1, 0.0, 8.0, 400.0);
        assert!((short.at(9.0) + 0.1 * (0.1_f64 / 400.0).sqrt()).abs() < 1e-14);
        let even = Braking::even(2.0, 0.25);
        assert!((even.at(0.125) - (2.0 * 0.125 - 4.0 * 0.125 * 0.125)).abs() < 1e-14);
        assert!((even.at(9.0) - 0.25).abs() < 1e-14);
        assert_eq!(Braking::with_jerk(0.0, 0.0, 8.0, 400.0).at(1.0), 0.0);
        assert_eq!(Braking::even(0.0, 0.0).at(1.0), 0.0);
    }
}
