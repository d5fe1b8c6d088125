//! The braking law: how a robot comes to a standstill from the state demanded last.
//!
//! Without a jerk limit all joints decelerate in one common time, so that the robot stays on the straight line
//! of its joint velocities; with one, each joint stops as fast as its acceleration and jerk allow.

use crate::model::joints::{JointVector, MAX_JOINTS};
use crate::model::robot::Limits;

/// How fast arms may slow down on their screw, so that no robot of an instruction exceeds its limits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BrakingLaw {
    /// By how much of the present speed the speed may fall in a second \[1/s\].
    pub fall: f64,
    /// Largest change of that \[1/s²\]; infinite where jerk has no limit.
    pub bend: f64,
}

impl BrakingLaw {
    /// The law of a robot that stands: it may stop at once.
    pub const UNLIMITED: BrakingLaw = BrakingLaw { fall: f64::INFINITY, bend: f64::INFINITY };

    /// The law for two robots together: the smaller of each value.
    #[must_use]
    pub fn and(self, other: BrakingLaw) -> BrakingLaw {
        BrakingLaw { fall: self.fall.min(other.fall), bend: self.bend.min(other.bend) }
    }

    /// Whether all robots may stand in the next step of `duration` \[s\].
    pub fn stops_at_once(&self, duration: f64) -> bool {
        // Then no joint is faster than what its acceleration limit takes away in a step, see `Acceptor::braking_law`.
        self.fall * duration >= SHARE * (1.0 - 1e-6)
    }
}

/// The share of an acceleration limit that braking on a screw plans with: the rest is for the screw's own curvature in the
/// joints.
pub(crate) const SHARE: f64 = 0.8;

/// One joint's way to zero velocity: acceleration ramps to `peak`, holds, ramps to zero.
#[derive(Clone, Copy, Debug, Default)]
struct JointBrake {
    v0: f64,
    a0: f64,
    /// Signed peak acceleration.
    peak: f64,
    jerk: f64,
    /// Durations of the three phases \[s\].
    ramp_in: f64,
    hold: f64,
    ramp_out: f64,
}

impl JointBrake {
    /// With a jerk limit: time-optimal from velocity `v` and acceleration `a`.
    fn with_jerk(v: f64, a: f64, limit: f64, jerk: f64) -> JointBrake {
        // Where the velocity ends when the acceleration alone goes to zero tells which way to push.
        let drift = v + a * a.abs() / (2.0 * jerk);
        if drift == 0.0 {
            let ramp_out = a.abs() / jerk;
            return JointBrake { v0: v, a0: a, peak: a, jerk, ramp_in: 0.0, hold: 0.0, ramp_out };
        }
        let sign = -drift.signum();
        let unlimited = (0.5 * a * a - sign * v * jerk).max(0.0).sqrt();
        let peak = unlimited.min(limit);
        let hold = if unlimited > limit {
            ((-sign * v - (2.0 * limit * limit - a * a) / (2.0 * jerk)) / limit).max(0.0)
        } else {
            0.0
        };
        JointBrake {
            v0: v,
            a0: a,
            peak: sign * peak,
            jerk,
            ramp_in: (sign * peak - a).abs() / jerk,
            hold,
            ramp_out: peak / jerk,
        }
    }

    /// Without a jerk limit: constant deceleration to zero in `duration`.
    fn without_jerk(v: f64, duration: f64) -> JointBrake {
        let peak = if duration > 0.0 { -v / duration } else { 0.0 };
        JointBrake { v0: v, a0: peak, peak, jerk: 0.0, ramp_in: 0.0, hold: duration, ramp_out: 0.0 }
    }

    fn duration(&self) -> f64 {
        self.ramp_in + self.hold + self.ramp_out
    }

    /// Displacement since the start and velocity at time `t` \[s\].
    fn at(&self, t: f64) -> (f64, f64) {
        let mut s = 0.0;
        let mut v = self.v0;
        let mut left = t.max(0.0);
        // Duration, acceleration at its beginning, jerk.
        let phases = [
            (self.ramp_in, self.a0, (self.peak - self.a0).signum() * self.jerk),
            (self.hold, self.peak, 0.0),
            (self.ramp_out, self.peak, -self.peak.signum() * self.jerk),
        ];
        for (duration, a, jerk) in phases {
            let d = left.min(duration);
            s += d * (v + d * (0.5 * a + d * jerk / 6.0));
            v += d * (a + 0.5 * d * jerk);
            left -= d;
        }
        if t >= self.duration() { (s, 0.0) } else { (s, v) }
    }
}

/// A robot's way to a standstill.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Braking<J> {
    start: J,
    joints: [JointBrake; MAX_JOINTS],
    elapsed: f64,
    duration: f64,
}

impl<J: JointVector> Braking<J> {
    /// From position, velocity and acceleration of the demand.
    pub fn new(position: J, velocity: J, acceleration: J, limits: &Limits<J>) -> Braking<J> {
        let mut joints = [JointBrake::default(); MAX_JOINTS];
        match limits.jerk {
            Some(jerk) => {
                for i in 0..J::LEN {
                    joints[i] =
                        JointBrake::with_jerk(velocity[i], acceleration[i], limits.acceleration[i], jerk[i]);
                }
            }
            None => {
                let time =
                    (0..J::LEN).map(|i| velocity[i].abs() / limits.acceleration[i]).fold(0.0, f64::max);
                for i in 0..J::LEN {
                    joints[i] = JointBrake::without_jerk(velocity[i], time);
                }
            }
        }
        let duration = joints.iter().map(JointBrake::duration).fold(0.0, f64::max);
        Braking { start: position, joints, elapsed: 0.0, duration }
    }

    /// Position and velocity after another `dt` \[s\].
    pub fn advance(&mut self, dt: f64) -> (J, J) {
        self.elapsed += dt;
        let position = J::from_joints(|i| self.start[i] + self.joints[i].at(self.elapsed).0);
        let velocity = J::from_joints(|i| self.joints[i].at(self.elapsed).1);
        (position, velocity)
    }

    /// Whether the robot stands.
    pub fn is_over(&self) -> bool {
        self.elapsed >= self.duration
    }
}

/// Distance that a joint with a jerk limit needs to stop [rad or m], in the direction of `v`, its mean velocity
/// in the last step of `duration` \[s\], and from its acceleration `a`.
pub(crate) fn stopping_distance(v: f64, a: f64, limit: f64, jerk: f64, duration: f64) -> f64 {
    // Only an acceleration that still drives the joint on makes it longer.
    let a = if a * v > 0.0 { a } else { 0.0 };
    let brake = JointBrake::with_jerk(v + 0.5 * a * duration, a, limit, jerk);
    brake.at(brake.duration()).0.abs()
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::SVector;

    fn limits(jerk: Option<f64>) -> Limits<SVector<f64, 2>> {
        Limits {
            lower: SVector::repeat(-9.0),
            upper: SVector::repeat(9.0),
            velocity: SVector::repeat(3.0),
            acceleration: SVector::repeat(10.0),
            jerk: jerk.map(SVector::repeat),
        }
    }

    #[test]
    fn without_a_jerk_limit_the_joints_stop_together_on_their_line() {
        let velocity = SVector::from([2.0, -0.5]);
        let mut braking = Braking::new(SVector::zeros(), velocity, SVector::zeros(), &limits(None));
        let mut position = SVector::zeros();
        let mut steps = 0;
        while !braking.is_over() {
            position = braking.advance(1e-3).0;
            steps += 1;
            assert!((position[0] * -0.25 - position[1]).abs() < 1e-12, "left the line at step {steps}");
        }
        // v / a = 0.2 s and v^2 / 2a = 0.2 rad.
        assert_eq!(steps, 200);
        assert!((position[0] - 0.2).abs() < 1e-12);
    }

    #[test]
    fn with_a_jerk_limit_the_worst_stop_takes_v_over_a_plus_two_and_a_half_a_over_j() {
        // safety.md: accelerating at +a when the stop arrives, 2.62/10 + 2.5 * 10/5000 = 0.267 s for an FR3.
        // The velocity limit is reached while the acceleration is being taken away, so 2.62 = v + a^2 / 2j.
        let brake = JointBrake::with_jerk(2.62, 10.0, 10.0, 5000.0);
        assert!(
            (brake.duration() - (2.62 / 10.0 + 2.5 * 10.0 / 5000.0)).abs() < 1e-12,
            "{}",
            brake.duration()
        );
    }

    #[test]
    fn a_braking_joint_keeps_acceleration_and_jerk_and_ends_at_rest() {
        for (v, a) in
            [(2.0, 0.0), (2.0, 10.0), (2.0, -10.0), (0.02, 9.0), (-1.0, 3.0), (0.05, -9.9), (0.0, 5.0)]
        {
            let brake = JointBrake::with_jerk(v, a, 10.0, 400.0);
            let dt = 1e-4;
            let mut v_last = v;
            let mut a_last = a;
            let steps = (brake.duration() / dt).ceil() as i32;
            for k in 1..=steps {
                let (_, v_now) = brake.at(f64::from(k) * dt);
                let a_now = (v_now - v_last) / dt;
                assert!(a_now.abs() <= 10.0 + 1e-6, "acceleration {a_now} from ({v}, {a})");
                if k > 1 {
                    assert!(
                        (a_now - a_last).abs() / dt <= 400.0 * (1.0 + 1e-6),
                        "jerk from ({v}, {a}) at {k}"
                    );
                }
                v_last = v_now;
                a_last = a_now;
            }
            let before_end = brake.at(brake.duration() - 1e-9).1;
            assert!(before_end.abs() < 1e-6, "ends with {before_end} from ({v}, {a})");
        }
    }

    #[test]
    fn a_joint_that_stops_before_it_brakes_with_all_it_has_takes_the_time_of_a_triangle() {
        // From a to -p and to 0 by j, with p² = a²/2 + j v: (2 p + a) / j. The last one has just begun to brake too hard.
        for (v, a) in [(0.4, 0.0), (0.4, 2.0), (0.12, -4.0), (0.09, -4.0)] {
            for sign in [1.0, -1.0] {
                let brake = JointBrake::with_jerk(sign * v, sign * a, 10.0, 100.0);
                let peak = f64::sqrt(0.5 * a * a + 100.0 * v);
                assert!((brake.duration() - (2.0 * peak + a) / 100.0).abs() < 1e-12, "({v}, {a})");
                // The mean of the velocities: each ramp's displacement is v t + a t²/2 + j t³/6.
                let (t, u) = ((peak + a) / 100.0, v + (a * a - peak * peak) / 200.0);
                let s = v * t + 0.5 * a * t * t - 100.0 * t * t * t / 6.0;
                let w = peak / 100.0;
                let s = s + u * w - 0.5 * peak * w * w + 100.0 * w * w * w / 6.0;
                let (way, end) = brake.at(brake.duration());
                assert!((way - sign * s).abs() < 1e-12 && end == 0.0, "({v}, {a}): {way}, {s}");
                // Halfway through the first ramp.
                let (way, speed) = brake.at(0.5 * t);
                let h = 0.5 * t;
                assert!((speed - sign * (v + a * h - 50.0 * h * h)).abs() < 1e-12, "({v}, {a})");
                assert!((way - sign * (v * h + 0.5 * a * h * h - 100.0 * h * h * h / 6.0)).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn a_joint_whose_acceleration_is_just_right_lets_it_go() {
        // v = a²/2j: a/j long, a³/6j² far.
        for sign in [1.0, -1.0] {
            let brake = JointBrake::with_jerk(sign * 0.5, sign * -10.0, 10.0, 100.0);
            assert!((brake.duration() - 0.1).abs() < 1e-12);
            assert!((brake.at(0.2).0 - sign * 1000.0 / 60_000.0).abs() < 1e-12);
        }
    }

    #[test]
    fn a_robot_that_stands_brakes_where_it_is() {
        for jerk in [None, Some(100.0)] {
            let at = SVector::from([0.3, -0.2]);
            let mut braking = Braking::new(at, SVector::zeros(), SVector::zeros(), &limits(jerk));
            assert!(braking.is_over());
            assert_eq!(braking.advance(1e-3), (at, SVector::zeros()));
        }
    }

    #[test]
    fn a_stopping_distance_is_that_of_ramps_and_of_constant_deceleration() {
        let (a, j) = (10.0, 1000.0);
        // With time for constant deceleration: v/2 (v/a + a/j).
        let level = |v: f64| 0.5 * v * (v / a + a / j);
        for sign in [1.0, -1.0] {
            let distance = |v: f64, a0: f64| stopping_distance(sign * v, sign * a0, a, j, 2e-3);
            assert!((distance(0.5, 0.0) - level(0.5)).abs() < 1e-12);
            // What it gains until its acceleration has gone, in b/j: v b/j + b³/3j², at v + b T/2 to begin with.
            let (b, v) = (4.0_f64, 0.5 + 0.5 * 4.0 * 2e-3);
            let gained = v * b / j + b.powi(3) / (3.0 * j * j);
            assert!((distance(0.5, b) - gained - level(v + b * b / (2.0 * j))).abs() < 1e-12);
            // An acceleration that brakes already is not counted upon.
            assert!((distance(0.5, -4.0) - level(0.5)).abs() < 1e-12);
            assert_eq!(distance(0.0, 4.0), 0.0);
        }
    }
}
