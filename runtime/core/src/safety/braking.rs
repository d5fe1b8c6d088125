//! The braking law: how a robot comes to a standstill from the state demanded last.
//!
//! Without a jerk limit all joints decelerate in the same time, so that the robot stays on a straight line in joint
//! space, in the direction of its joint velocities. With a jerk limit each joint stops as fast as its limits of
//! acceleration and jerk allow. The jerk limit bounds how much the acceleration changes from one step to the next, so
//! braking is computed in steps, too. The first step of a curve in continuous time would take away half of the
//! acceleration at once, or hardly any of it, and the joint would exceed its velocity limit.

use crate::model::joints::JointVector;
use crate::model::robot::Limits;
use crate::safety::ramp::steepest;
use crate::safety::rate::smaller;

/// How fast arms may slow down on their twist, so that no robot of an instruction exceeds its limits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BrakingLaw {
    /// The share of the present speed by which the speed may fall in a second \[1/s\].
    pub fall: f64,
    /// The largest change of `fall` in a second \[1/s²\]; infinite without a jerk limit.
    pub bend: f64,
}

impl BrakingLaw {
    /// The law of a robot that stands: it may stop at once.
    pub const UNLIMITED: BrakingLaw = BrakingLaw { fall: f64::INFINITY, bend: f64::INFINITY };

    /// The law for two robots together: the smaller of each value.
    #[must_use]
    #[inline]
    pub fn and(self, other: BrakingLaw) -> BrakingLaw {
        BrakingLaw { fall: smaller(self.fall, other.fall), bend: smaller(self.bend, other.bend) }
    }

    /// Whether all robots may stand in the next step of `duration` \[s\].
    pub fn stops_at_once(&self, duration: f64) -> bool {
        // Then the acceleration limit of every joint can take away its whole speed in one step, see
        // `Acceptor::braking_law`.
        self.fall * duration >= SHARE * (1.0 - 1e-6)
    }
}

/// The share of an acceleration limit that braking on a twist uses at most. The rest is for the curvature of the twist in joint
/// space, which leaves less where it takes more.
pub(crate) const SHARE: f64 = 0.8;

/// A robot's braking to a standstill.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Braking<J> {
    /// Without a jerk limit.
    Even(EvenBraking<J>),
    /// With one, in steps.
    Jerk(JerkBraking<J>),
}

/// All joints decelerate evenly and stand at the same time.
#[derive(Clone, Copy, Debug)]
pub(crate) struct EvenBraking<J> {
    start: J,
    velocity: J,
    acceleration: J,
    elapsed: f64,
    duration: f64,
}

/// Each joint stops by itself. The fields hold the position demanded last, the mean velocity of the step to it, and the
/// acceleration that led to this velocity.
#[derive(Clone, Copy, Debug)]
pub(crate) struct JerkBraking<J> {
    position: J,
    velocity: J,
    acceleration: J,
    limit: J,
    jerk: J,
    stands: bool,
}

impl<J: JointVector> Braking<J> {
    /// From position, velocity and acceleration of the last demand.
    pub fn new(position: J, velocity: J, acceleration: J, limits: &Limits<J>) -> Braking<J> {
        match limits.jerk {
            Some(jerk) => Braking::Jerk(JerkBraking {
                position,
                velocity,
                acceleration,
                limit: limits.acceleration,
                jerk,
                stands: velocity == J::zeros() && acceleration == J::zeros(),
            }),
            None => {
                let duration =
                    (0..J::LEN).map(|i| velocity[i].abs() / limits.acceleration[i]).fold(0.0, f64::max);
                let acceleration =
                    if duration > 0.0 { J::from_joints(|i| -velocity[i] / duration) } else { J::zeros() };
                Braking::Even(EvenBraking { start: position, velocity, acceleration, elapsed: 0.0, duration })
            }
        }
    }

    /// Position and velocity after another step of `dt` \[s\].
    pub fn advance(&mut self, dt: f64) -> (J, J) {
        match self {
            Braking::Even(braking) => braking.advance(dt),
            Braking::Jerk(braking) => braking.advance(dt),
        }
    }

    /// Whether the robot stands: it may stay where it is in its next step.
    pub fn is_over(&self) -> bool {
        match self {
            Braking::Even(braking) => braking.elapsed >= braking.duration,
            Braking::Jerk(braking) => braking.stands,
        }
    }
}

impl<J: JointVector> EvenBraking<J> {
    fn advance(&mut self, dt: f64) -> (J, J) {
        self.elapsed += dt;
        let t = self.elapsed.min(self.duration);
        let displacement = J::from_joints(|i| t * (self.velocity[i] + t * (0.5 * self.acceleration[i])));
        let stands = self.elapsed >= self.duration;
        let velocity = if stands { J::zeros() } else { self.velocity + self.acceleration * t };
        (self.start + displacement, velocity)
    }
}

impl<J: JointVector> JerkBraking<J> {
    fn advance(&mut self, dt: f64) -> (J, J) {
        self.stands = true;
        for i in 0..J::LEN {
            let (limit, jerk) = (self.limit[i], self.jerk[i]);
            let a = braking_acceleration(self.velocity[i], self.acceleration[i], limit, jerk, dt);
            let v = self.velocity[i] + a * dt;
            self.acceleration[i] = a;
            // The step that takes away the rest of the velocity leaves round-off.
            self.velocity[i] = if v.abs() <= 1e-9 * limit * dt { 0.0 } else { v };
            self.stands &= self.velocity[i] == 0.0 && a.abs() <= jerk * dt * (1.0 + 1e-9);
        }
        self.position = self.position + self.velocity * dt;
        (self.position, self.velocity)
    }
}

/// How a joint moves while its acceleration goes to 0, by the jerk limit in every step. No other motion within that limit
/// changes its velocity by less.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Release {
    /// By how much its velocity changes [rad/s or m/s].
    pub gain: f64,
    /// The time that this takes \[s\].
    pub time: f64,
    /// What is left of the acceleration after that: less than one step takes away [rad/s² or m/s²].
    pub left: f64,
}

impl Release {
    /// From the acceleration `a` of the last step of `dt` \[s\]. It takes `n` steps, `n = |a| / j T` rounded down; the
    /// `m`-th of them still has the acceleration `|a| - m j T`.
    pub fn new(a: f64, jerk: f64, dt: f64) -> Release {
        let change = jerk * dt;
        let n = (a.abs() / change).floor();
        let gain = dt * n * (a.abs() - 0.5 * change * (n + 1.0));
        Release { gain: gain.copysign(a), time: n * dt, left: (a.abs() - n * change).copysign(a) }
    }
}

/// The acceleration of the next step of the fastest motion to a standstill, from velocity `v` and acceleration `a` of the
/// last step. It is the hardest deceleration that can still go to 0 before the joint reverses.
fn braking_acceleration(v: f64, a: f64, limit: f64, jerk: f64, dt: f64) -> f64 {
    let change = jerk * dt;
    let hardest = steepest(v.abs() / dt, change).min(limit);
    let wanted = if v > 0.0 { -hardest } else { hardest };
    wanted.clamp(a - change, a + change)
}

/// Distance that a joint with a jerk limit needs to stop [rad or m], in the direction of `v`. `v` is its mean velocity
/// in the last step of `duration` \[s\], and `a` its acceleration. The distance is that of the fastest curve in
/// continuous time; braking in steps never exceeds it.
pub(crate) fn stopping_distance(v: f64, a: f64, limit: f64, jerk: f64, duration: f64) -> f64 {
    // Only an acceleration in the direction of motion makes the distance longer.
    let a = if a * v > 0.0 { a.abs() } else { 0.0 };
    let v = v.abs() + 0.5 * a * duration;
    // The acceleration goes to -p and back to 0, with p² = a²/2 + j v. If p is beyond the limit, the acceleration stays
    // at the limit for `hold`.
    let unlimited = (0.5 * a * a + v * jerk).sqrt();
    let peak = unlimited.min(limit);
    let hold = if unlimited > limit {
        ((v - (2.0 * limit * limit - a * a) / (2.0 * jerk)) / limit).max(0.0)
    } else {
        0.0
    };
    let mut distance = 0.0;
    let mut speed = v;
    for (time, a, jerk) in [((a + peak) / jerk, a, -jerk), (hold, -peak, 0.0), (peak / jerk, -peak, jerk)] {
        distance += time * (speed + time * (0.5 * a + time * jerk / 6.0));
        speed += time * (a + 0.5 * time * jerk);
    }
    distance
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

    /// Brakes a joint from `v` and `a` within 10 m/s² and `jerk` in steps of `dt`: the velocities and accelerations.
    fn braked(v: f64, a: f64, jerk: f64, dt: f64) -> Vec<(f64, f64)> {
        let limits = Limits { jerk: Some(SVector::repeat(jerk)), ..limits(None) };
        let (velocity, acceleration) = (SVector::from([v, 0.0]), SVector::from([a, 0.0]));
        let mut braking = Braking::new(SVector::zeros(), velocity, acceleration, &limits);
        let mut states: Vec<(f64, f64)> = Vec::new();
        while !braking.is_over() {
            let before = states.last().map_or(v, |state| state.0);
            let velocity = braking.advance(dt).1[0];
            states.push((velocity, (velocity - before) / dt));
            assert!(states.len() < 100_000, "no end from ({v}, {a})");
        }
        states
    }

    #[test]
    fn with_a_jerk_limit_the_worst_stop_takes_v_over_a_plus_two_and_a_half_a_over_j() {
        // safety.md: accelerating at +a when the stop arrives, 2.62/10 + 2.5 * 10/5000 = 0.267 s for an FR3. The velocity
        // limit is reached while the acceleration is taken away: 2.62 = v + a²/2j - a T/2 in steps of T.
        // Steps: +5, 0, -5, -10 mm/s, 260 times -10, -5.
        let steps = braked(2.62 - 0.01 + 0.005, 10.0, 5000.0, 1e-3).len();
        assert_eq!(steps, 265);
    }

    #[test]
    fn a_braking_joint_keeps_acceleration_and_jerk_and_goes_no_faster_than_it_must() {
        for (v, a) in
            [(2.0_f64, 0.0), (2.0, 10.0), (2.0, -10.0), (0.02, 9.0), (-1.0, 3.0), (0.05, -9.9), (0.0, 5.0)]
        {
            for (dt, jerk) in [(1e-3, 400.0), (2e-3, 5000.0), (1e-2, 100.0), (2e-2, 100.0), (2e-2, 1e4)] {
                let fastest = v.abs().max((v + Release::new(a, jerk, dt).gain).abs());
                let mut before = a;
                for (v, a) in braked(v, a, jerk, dt) {
                    assert!(a.abs() <= 10.0 * (1.0 + 1e-9), "acceleration {a}");
                    assert!((a - before).abs() <= jerk * dt * (1.0 + 1e-6), "jerk from {before} to {a}");
                    assert!(v.abs() <= fastest + 1e-12, "{v} instead of {fastest}");
                    before = a;
                }
                // It may stay where it is.
                assert!(before.abs() <= jerk * dt * (1.0 + 1e-6));
            }
        }
    }

    proptest::proptest! {
        #[test]
        fn braking_takes_no_longer_and_goes_no_farther_than_its_bounds(
            v in -3.0..3.0_f64, a in -10.0..10.0_f64, small in 0..4_i32, decades in 0.0..4.0_f64,
            dt in proptest::sample::select(vec![1e-3, 2e-3, 4e-3, 1e-2, 2e-2]),
        ) {
            let jerk = 10.0 * 10.0_f64.powf(decades);
            let v = v * 0.1_f64.powi(small);
            let release = Release::new(a, jerk, dt);
            let kept = v + release.gain;
            let states = braked(v, a, jerk, dt);
            // The step in which it is over may have just begun.
            let longest = v.abs() / 10.0 + 2.5 * 10.0 / jerk + dt;
            proptest::prop_assert!(states.len() as f64 * dt <= longest + 1e-9, "{} steps", states.len());
            let ahead = |sign: f64| {
                let at_once = if sign * v > 0.0 { stopping_distance(v, a, 10.0, jerk, dt) } else { 0.0 };
                let later = kept.abs() * release.time + stopping_distance(kept, release.left, 10.0, jerk, dt);
                at_once.max(if sign * kept > 0.0 { later } else { 0.0 })
            };
            let (up, down) = (ahead(1.0), ahead(-1.0));
            let mut position = 0.0;
            for (velocity, _) in states {
                position += velocity * dt;
                proptest::prop_assert!(-down - 1e-12 <= position && position <= up + 1e-12);
            }
        }
    }

    #[test]
    fn letting_go_of_an_acceleration_is_the_sum_of_what_is_left_of_it() {
        // 4 m/s² by 1 m/s² a step of 1 ms: 3, 2, 1, 0 mm/s more.
        for sign in [1.0, -1.0] {
            let release = Release::new(sign * 4.0, 1000.0, 1e-3);
            assert!((release.gain - sign * 6e-3).abs() < 1e-15);
            assert!((release.time - 4e-3).abs() < 1e-15);
        }
        // Less than a step's change is gone in the next one.
        let release = Release::new(0.9, 1000.0, 1e-3);
        assert_eq!((release.gain, release.time, release.left), (0.0, 0.0, 0.9));
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
