//! How long a stop takes: noticing that one is due, then braking.
//!
//! In: limits, the cell's step. Out: times and steps. Braking from the velocity limit, accelerating at the limit when
//! the stop arrives, takes `T_brake = v / a + 2.5 a / j`: 2 a / j to swing the acceleration round, v / a - a / 2 j at
//! the limit, a / j to let it go; without a jerk limit `v / a`. `T_stop = T_detect + T_brake`; the longest detection
//! is that of a lost peer, the missed-step budget and the step after it.

use core::time::Duration;

use crate::model::joints::JointVector;
use crate::model::robot::Limits;
use crate::safety::braking::SHARE;

/// The longest stop that a cell takes unless it says otherwise.
pub(crate) const STOP_TIME: Duration = Duration::from_millis(600);

/// Missed steps that an EDP bridges before it brakes: 20 ms of steps (`L` of SAFETY.md).
pub fn missed_step_budget(step: Duration) -> u32 {
    let step = step.as_nanos().max(1);
    u32::try_from(20_000_000_u128.div_ceil(step)).unwrap_or(u32::MAX)
}

/// Missed steps that an EDP goes on for along the twist of robots that move together. An MP that has had no answer from one of
/// them for so many steps stops all: each of them begins in the same step, whether the order of the first of these steps has
/// come to it or not (decision 8).
///
/// An arm that misses its orders alone is off the others by what its path has changed meanwhile: after `n` steps by
/// `n (n + 1) / 2 a Ts²`, where the acceleration of the path jumps by `a`. So many steps are bridged as keep that within
/// 0.05 mm for a jump of 2 m/s², and at least two, which the agreement needs; steps of 20 ms and more leave time for a single one.
pub fn together_budget(step: Duration) -> u32 {
    let seconds = step.as_secs_f64().max(1e-9);
    let steps = ((1.0 + 8.0 * APART / (JUMP * seconds * seconds)).sqrt() - 1.0) / 2.0;
    // `as` saturates: no float is out of range.
    (steps as u32).max(2).min(missed_step_budget(step))
}

/// How far an arm that misses its orders alone may come off the others, where its path jumps by [`JUMP`] \[m\].
const APART: f64 = 50e-6;

/// The largest jump of the acceleration of a path that arms go together [m/s²]: from 1 m/s² to as much in the other direction.
const JUMP: f64 = 2.0;

/// The longest time until an EDP brakes when its demands are lost \[s\]: the missed steps that it bridges, 20 ms of them, and the step
/// after these. Until then the robot goes on at its velocity. A program that looks at a motion before it begins it needs this, to know that
/// the robot keeps its limits in a stop from each step of it, too.
#[must_use]
pub fn detection_time(step: Duration) -> f64 {
    step.as_secs_f64() * (f64::from(missed_step_budget(step)) + 1.0)
}

/// The longest time until the robots of a cell begin to stop for what is lost \[s\]: a peer, or a robot that paces itself and may
/// say nothing for `silence`.
pub(crate) fn noticing_time(step: Duration, silence: Duration) -> f64 {
    detection_time(step).max(silence.as_secs_f64())
}

/// The longest time that a joint brakes for \[s\].
pub(crate) fn braking_time<J: JointVector>(limits: &Limits<J>, joint: usize) -> f64 {
    let v = limits.velocity[joint];
    let a = limits.acceleration[joint];
    v / a + limits.jerk.map_or(0.0, |jerk| 2.5 * a / jerk[joint])
}

/// The same of the joint that brakes longest.
pub(crate) fn longest_braking<J: JointVector>(limits: &Limits<J>) -> f64 {
    (0..J::LEN).map(|i| braking_time(limits, i)).fold(0.0, f64::max)
}

/// Steps within which every joint of a robot must stand after a stop began: detection, braking with the share of its
/// acceleration that it brakes with on a twist, and what its drives lie behind its demands, at most `delay`. Robots that move
/// together brake as the slowest of them does: the bound of a cell is the largest of its robots'.
pub(crate) fn stop_steps<J: JointVector>(limits: &Limits<J>, step: Duration, delay: Duration) -> u64 {
    let seconds = detection_time(step) + longest_braking(limits) / SHARE + delay.max(2 * step).as_secs_f64();
    // `as` saturates: no float is out of range.
    (seconds / step.as_secs_f64()).ceil() as u64
}

/// Steps that a protective stop may take on the path, where a stop may take `stop_time` in all: what is left is for the
/// order that ends it, and for a stop as above without its detection. Both times are a robot's; a cell keeps to the least
/// number of steps of its robots.
pub(crate) fn path_stop_steps(stop_time: Duration, braking: f64, step: Duration, delay: Duration) -> u64 {
    let after = braking / SHARE + delay.max(2 * step).as_secs_f64() + 2.0 * step.as_secs_f64();
    // `as` saturates: what is below 0 is 0.
    ((stop_time.as_secs_f64() - after) / step.as_secs_f64()).floor() as u64
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector1;

    fn limits(v: f64, a: f64, jerk: Option<f64>) -> Limits<Vector1<f64>> {
        Limits {
            lower: Vector1::new(-1.0),
            upper: Vector1::new(1.0),
            velocity: Vector1::new(v),
            acceleration: Vector1::new(a),
            jerk: jerk.map(Vector1::new),
        }
    }

    #[test]
    fn the_braking_times_are_those_of_real_arms() {
        // safety.md: FR3 0.267 s and 0.531 s, Panda's second joint 0.295 s; the IRp-6 1.5/7 s.
        for (v, a, jerk, seconds) in [
            (2.62, 10.0, Some(5000.0), 0.267),
            (5.26, 10.0, Some(5000.0), 0.531),
            (2.175, 7.5, Some(3750.0), 0.295),
            (1.5, 7.0, None, 1.5 / 7.0),
        ] {
            assert!((braking_time(&limits(v, a, jerk), 0) - seconds).abs() < 1e-12, "{v}, {a}, {jerk:?}");
        }
    }

    #[test]
    fn a_lost_peer_is_noticed_after_the_budget_and_one_step() {
        assert!((detection_time(Duration::from_millis(1)) - 0.021).abs() < 1e-12);
        assert!((detection_time(Duration::from_millis(2)) - 0.022).abs() < 1e-12);
        let (step, millis) = (Duration::from_millis(2), Duration::from_millis);
        assert_eq!(noticing_time(step, millis(10)), detection_time(step));
        assert_eq!(noticing_time(step, millis(400)), 0.4);
        // 1.0 / 10 s of braking, on a twist 1.0 / 8 s; 21 ms, 8 ms.
        let steps = stop_steps(&limits(1.0, 10.0, None), Duration::from_millis(1), Duration::from_millis(8));
        assert!((154..=155).contains(&steps), "{steps}");
    }

    #[test]
    fn a_protective_stop_has_what_a_fault_stop_leaves_of_the_time() {
        // 600 ms less 1.0 / 10 s of braking, on a twist 1.0 / 8 s, 8 ms and two steps.
        let millis = Duration::from_millis;
        assert_eq!(path_stop_steps(millis(600), 0.1, millis(2), millis(8)), (600 - 125 - 8 - 4) / 2);
        assert_eq!(path_stop_steps(millis(100), 0.1, millis(2), millis(8)), 0);
    }

    #[test]
    fn a_budget_is_twenty_milliseconds_of_steps_and_a_part_of_one_counts_whole() {
        for (micros, budget) in [(1000, 20), (2000, 10), (8000, 3), (20_000, 1), (50_000, 1)] {
            assert_eq!(missed_step_budget(Duration::from_micros(micros)), budget, "{micros}");
        }
        assert_eq!(missed_step_budget(Duration::ZERO), 20_000_000);
    }

    #[test]
    fn a_stop_is_awaited_for_detection_braking_on_a_twist_and_the_delay_of_the_drives() {
        // 20 ms are 5 steps of 4 ms, and one: 24 ms. (1/2 + 2.5 * 2/10) / 0.8 = 1.25 s. 10.1 ms of delay: 1284.1 ms.
        let arm = limits(1.0, 2.0, Some(10.0));
        let millis = Duration::from_millis;
        assert_eq!(stop_steps(&arm, millis(4), Duration::from_micros(10_100)), 322);
        // A delay of two steps at least: 24 + 1250 + 8 = 1282 ms.
        assert_eq!(stop_steps(&arm, millis(4), millis(1)), 321);
    }
}
