//! How far joints still move when a robot is stopped now.
//!
//! In: the demanded speeds `v` and the limits of acceleration `a` (and jerk `j`). Out: a distance that no joint exceeds until it
//! stands. First the time `reaction` passes, in which a joint may still gain speed:
//!
//! ```text
//! distances >= v t + a t^2 / 2,     then  v' = v + a t
//! ```
//!
//! **Braking**, as when a peer is lost: without jerk limits all joints decelerate evenly in one time `T = max v'/a`, so
//! `v' T / 2`. With them each joint by itself: its acceleration, at most `a`, first fades (`a/j`, gaining `a^2/2j`), and from
//! `v'' = v' + a^2/2j` it needs at most `v''/a + a/j`, half of it at `v''`.
//!
//! **On the path**, as for a guard's fault: the rate `r` falls from 1 by at most `c` per second and by what the robots have left,
//! `k (0.98 - 0.9 r^2)` with `1/k = max v'/a + step` over all joints of all robots: they slow down together. Along the path
//! passes
//!
//! ```text
//! integral r dt <= integral_0^1 r / c dr + integral_0^1 r / k(0.98 - 0.9 r^2) dr = 1 / 2c + ln(0.98/0.08) / 1.8k
//! ```
//!
//! (1.392 / k) of path time, in which the joints move at `v'`. At a rate below 1 it is less. With a jerk limit the fall is bounded by
//! `0.04 j / 2.7 a` per second as well, and bends by `0.04 j k / a`: it takes `2 x 24.5 a/j` at most until the fall is as steep as it
//! may be, and to end it.
//!
//! **Backwards**, against its velocity, a joint gets in a stop only after it has turned round: not while it brakes by itself, if it is fast enough
//! that neither the reaction nor a fading acceleration turn it round (`v >= a reaction + a^2/2j`). On the path, which may turn at any place, it takes
//! at least `v/a` of path time to turn round; in the path time `P` of reaction and stop it gets back by `a P^2 / 2 - v P` at most.
//!
//! This assumes that within the stop the path, at rate 1, is nowhere faster than now. Where it is, the next check finds the
//! longer distance; a margin covers the difference of one check.

use core::time::Duration;

use mrroc::robot::{JointVector, Limits};

/// ln(0.98/0.08) / 1.8: path time of a stop from rate 1, per `max v/a`.
const ON_PATH: f64 = 1.392;
/// Largest fall of the rate by a limit of jerk, per j/a.
const FALL_BY_JERK: f64 = 0.04 / 2.7;
/// Time in which the fall of the rate begins and ends, by a limit of jerk, per a/j.
const BEND_BY_JERK: f64 = 2.0 * 0.98 / 0.04;

/// How a stop goes on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Stop {
    /// By the braking law, every robot for itself.
    Braking,
    /// On the paths, all robots together.
    OnPath {
        /// Largest change of the rate \[1/s\]: 5 unless the cell says otherwise.
        rate_change: f64,
        /// The cell's step \[s\].
        step: f64,
    },
}

/// How a stop begins and goes on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stopping {
    /// Time from the state that is looked at to where the stop begins at the latest \[s\], >= 0.
    pub reaction: f64,
    /// How the stop goes on.
    pub stop: Stop,
}

impl Stopping {
    /// The stop that a guard's fault causes, in a cell with this step whose guard is called every so many steps. The guard
    /// sees the states of the step before, and the stop begins in the next one.
    #[must_use]
    pub fn of_guard(step: Duration, every: u32) -> Self {
        let step = step.as_secs_f64();
        Self {
            reaction: step * (f64::from(every.max(1)) + 2.0),
            stop: Stop::OnPath { rate_change: 5.0, step },
        }
    }

    /// The path time that passes at most from the state that is looked at until robots stand that stop on their paths \[s\]; `None` where
    /// they leave them. `slowest` \[s\], >= 0, is the largest speed of a joint on the path by its limit of acceleration, at rate 1,
    /// and `jerkiest` \[s\], >= 0, the largest limit of acceleration by that of jerk.
    #[must_use]
    pub fn on_path(&self, slowest: f64, jerkiest: f64) -> Option<f64> {
        match self.stop {
            Stop::Braking => None,
            Stop::OnPath { rate_change, step } => {
                Some(self.reaction + self.path_time(rate_change, step, &Pace { slowest, jerkiest }))
            }
        }
    }

    /// Speeds at the beginning of the stop are at most this.
    fn speed(&self, v: f64, a: f64) -> f64 {
        v.abs() + a * self.reaction
    }

    /// The largest `v'/a` of a robot's joints \[s\], and the largest `a/j` \[s\], 0 without limits of jerk.
    pub(super) fn pace<J: JointVector>(&self, limits: &Limits<J>, velocity: &[f64]) -> Pace {
        let mut pace = Pace::default();
        for (i, v) in velocity.iter().enumerate().take(J::LEN) {
            let a = limits.acceleration[i];
            pace.slowest = pace.slowest.max(self.speed(*v, a) / a);
            pace.jerkiest = pace.jerkiest.max(limits.jerk.map_or(0.0, |jerk| a / jerk[i]));
        }
        pace
    }

    /// Ways of a robot's joints until they stand [rad or m], >= 0, when the robots of the cell have this pace.
    pub(super) fn stopping_distances<J: JointVector>(
        &self,
        limits: &Limits<J>,
        velocity: &[f64],
        cell: &Pace,
    ) -> J {
        let own = self.pace(limits, velocity);
        J::from_joints(|i| {
            let (v, a) = (velocity[i].abs(), limits.acceleration[i]);
            let faster = self.speed(v, a);
            let before = 0.5 * (v + faster) * self.reaction;
            before
                + match (self.stop, limits.jerk) {
                    (Stop::Braking, None) => 0.5 * faster * own.slowest,
                    (Stop::Braking, Some(jerk)) => braking_distance(faster, a, jerk[i]),
                    (Stop::OnPath { rate_change, step }, _) => {
                        faster * self.path_time(rate_change, step, cell)
                    }
                }
        })
    }

    /// How far against its velocity a joint may get until it stands, of the distance that it may get at all [rad or m], >= 0; the robots of
    /// the cell have this pace.
    pub(super) fn backwards<J: JointVector>(
        &self,
        limits: &Limits<J>,
        velocity: &[f64],
        distances: &J,
        cell: &Pace,
    ) -> J {
        J::from_joints(|i| {
            let (v, a) = (velocity[i].abs(), limits.acceleration[i]);
            match self.stop {
                Stop::Braking => {
                    let fading = limits.jerk.map_or(0.0, |jerk| 0.5 * a * a / jerk[i]);
                    if v >= a * self.reaction + fading { 0.0 } else { distances[i] }
                }
                Stop::OnPath { rate_change, step } => {
                    let path = self.reaction + self.path_time(rate_change, step, cell);
                    (path * (0.5 * a * path - v)).clamp(0.0, distances[i])
                }
            }
        })
    }

    /// Path time that passes at most in a stop on the path \[s\].
    fn path_time(&self, rate_change: f64, step: f64, cell: &Pace) -> f64 {
        let even = 0.5 / rate_change + ON_PATH * (cell.slowest + step);
        even + cell.jerkiest * (0.5 / FALL_BY_JERK + BEND_BY_JERK)
    }
}

/// How far a joint gets at most that brakes by itself from `speed`, >= 0, within limits of acceleration and jerk, each > 0 [rad or m]: its
/// acceleration first fades, in which it may still gain speed.
#[must_use]
pub fn braking_distance(speed: f64, acceleration: f64, jerk: f64) -> f64 {
    let fading = acceleration / jerk;
    let fastest = speed + 0.5 * acceleration * fading;
    fastest * fading + 0.5 * fastest * (fastest / acceleration + fading)
}

/// What the slowest joint to stop needs.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pace {
    /// Largest v/a \[s\].
    slowest: f64,
    /// Largest a/j \[s\].
    jerkiest: f64,
}

impl Pace {
    /// That of both.
    pub(super) fn and(self, other: Self) -> Self {
        Self { slowest: self.slowest.max(other.slowest), jerkiest: self.jerkiest.max(other.jerkiest) }
    }
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
            acceleration: SVector::from([7.0, 2.0]),
            jerk: jerk.map(SVector::repeat),
        }
    }

    fn stopping_distances(
        stopping: Stopping,
        limits: &Limits<SVector<f64, 2>>,
        v: [f64; 2],
    ) -> SVector<f64, 2> {
        stopping.stopping_distances(limits, &v, &stopping.pace(limits, &v))
    }

    #[test]
    fn braking_takes_half_of_v_t_with_the_time_of_the_slowest_joint() {
        // Joint 2 needs 0.5 s, joint 1 would need 0.2 s: 1.4 x 0.5 / 2 and 1 x 0.5 / 2.
        let distances =
            stopping_distances(Stopping { reaction: 0.0, stop: Stop::Braking }, &limits(None), [-1.4, 1.0]);
        assert!((distances - SVector::from([0.35, 0.25])).amax() < 1e-15);
    }

    #[test]
    fn a_joint_may_gain_speed_before_the_stop_begins() {
        // In 0.1 s from rest to 0.7 and 0.2 rad/s, after 0.035 and 0.01 rad; both then need 0.1 s.
        let distances =
            stopping_distances(Stopping { reaction: 0.1, stop: Stop::Braking }, &limits(None), [0.0, 0.0]);
        assert!((distances - SVector::from([0.07, 0.02])).amax() < 1e-15);
    }

    #[test]
    fn braking_with_limited_jerk_takes_no_longer_way_than_the_bound() {
        // From v with the acceleration a still driving: it fades within a/j; then the time-optimal motion to rest, with or
        // without reaching the largest deceleration, 2 rad/s^2.
        for (v, a, jerk) in [(1.0, 2.0, 50.0), (0.05, 2.0, 5.0), (2.0, 1.0, 20.0), (0.5, 0.0, 100.0)] {
            let fading: f64 = a / jerk;
            let fastest = v + 0.5 * a * fading;
            let fades = v * fading + a * fading * fading / 3.0;
            let time = if fastest >= 4.0 / jerk {
                fastest / 2.0 + 2.0 / jerk
            } else {
                2.0 * (fastest / jerk).sqrt()
            };
            let exact = fades + 0.5 * fastest * time;
            let stopping = Stopping { reaction: 0.0, stop: Stop::Braking };
            let distances = stopping_distances(stopping, &limits(Some(jerk)), [0.0, v])[1];
            assert!(distances >= exact, "{v} {a} {jerk}: {distances} {exact}");
        }
    }

    #[test]
    fn on_the_path_a_joint_gets_no_farther_back_than_the_bound() {
        let mut random = mrroc::random::Random::seeded(5);
        for _ in 0..2000 {
            let (reaction, step) = (random.between(0.0, 0.05), 0.002);
            let stopping = Stopping { reaction, stop: Stop::OnPath { rate_change: 5.0, step } };
            let limits = limits(None);
            let v = [random.between(0.0, 3.0), random.between(0.0, 3.0)];
            let pace = stopping.pace(&limits, &v);
            let distances: SVector<f64, 2> = stopping.stopping_distances(&limits, &v, &pace);
            let back: SVector<f64, 2> = stopping.backwards(&limits, &v, &distances, &pace);
            // The path time that passes at most, by the module's equations; the path turns as sharply as the limits allow, here and there.
            let gained = (0..2).map(|i| v[i] / limits.acceleration[i]).fold(0.0, f64::max) + reaction;
            let time = reaction + 0.1 + 1.392 * (gained + step);
            for i in 0..2 {
                let (mut q, mut speed, dt) = (0.0_f64, v[i], time / 500.0);
                let turns = random.between(0.0, 1.0);
                for k in 0..500 {
                    let a = if f64::from(k) / 500.0 < turns { -1.0 } else { random.between(-1.0, 1.0) };
                    let a = a * limits.acceleration[i];
                    // No faster than the path is now, and the reaction lets it become.
                    let fastest = v[i] + limits.acceleration[i] * reaction;
                    let next = (speed + a * dt).clamp(-fastest, fastest);
                    q += 0.5 * (speed + next) * dt;
                    speed = next;
                    assert!(-q <= back[i] + 1e-9, "{v:?} {reaction}: {} {}", -q, back[i]);
                }
            }
        }
    }

    #[test]
    fn a_joint_that_brakes_fast_enough_does_not_turn_round() {
        let stopping = Stopping { reaction: 0.1, stop: Stop::Braking };
        let back = |v: [f64; 2]| -> SVector<f64, 2> {
            let (limits, pace) = (limits(None), stopping.pace(&limits(None), &v));
            stopping.backwards(&limits, &v, &stopping.stopping_distances(&limits, &v, &pace), &pace)
        };
        // In 0.1 s at 7 and 2 rad/s^2 the joints may lose 0.7 and 0.2 rad/s.
        assert_eq!(back([-0.71, 0.21]), SVector::from([0.0, 0.0]));
        assert!(back([0.69, -0.19]).min() > 0.0);
    }

    #[test]
    fn on_the_path_the_way_covers_the_integral_of_the_rate() {
        let step = 0.002;
        for change in [0.5, 5.0, 50.0] {
            for v in [[0.01, 0.0], [1.0, 0.3], [0.2, 2.0], [3.0, 3.0]] {
                // dr/dt as the feed has it, from rate 1.
                let slowest: f64 = (v[0] / 7.0_f64).max(v[1] / 2.0);
                let (mut rate, mut path, dt) = (1.0_f64, 0.0, 1e-5);
                while rate > 0.0 {
                    path += rate * dt;
                    rate -= dt * ((0.98 - 0.9 * rate * rate) / (slowest + step)).min(change);
                }
                let stopping = Stopping { reaction: 0.0, stop: Stop::OnPath { rate_change: change, step } };
                let distances = stopping_distances(stopping, &limits(None), v);
                for i in 0..2 {
                    let exact = v[i] * path;
                    assert!(distances[i] >= exact * (1.0 - 1e-3), "{change} {v:?}: {} {exact}", distances[i]);
                    // One of the two bounds may be taken in vain.
                    assert!(distances[i] <= 2.0 * exact + 1e-12, "{change} {v:?}: {} {exact}", distances[i]);
                }
            }
        }
    }
}
