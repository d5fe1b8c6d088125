//! What an FR3 takes of positions that it is told.
//!
//! In: where it is, and where it is told to be a period later. Out: the limit that this breaks, if it does. The robot checks the
//! same and stops with a reflex; here it is refused before. The figures are those of libfranka's `rate_limiting.h`, which are
//! narrower than the data sheet's: a robot may allow more (its own are in the URDF that it gives).

use mrroc::fault::Excess;
use mrroc::robot::{CoupledLimit, DriveFault};

use crate::message::JOINTS;
use crate::rejoining::{Joints, PERIOD, Setpoint};

/// Least and greatest positions \[rad\].
pub const POSITIONS: [(f64, f64); JOINTS] = [
    (-2.7501, 2.7501),
    (-1.7918, 1.7918),
    (-2.9065, 2.9065),
    (-3.0481, -0.1458),
    (-2.8101, 2.8101),
    (0.540_92, 4.5205),
    (-3.0196, 3.0196),
];

/// Greatest speed [rad/s], what is kept of it before a limit of position [rad/s], and the deceleration towards that [rad/s²].
const SPEEDS: [(f64, f64, f64); JOINTS] = [
    (2.62, 0.30, 6.0),
    (2.62, 0.20, 2.585),
    (2.62, 0.20, 3.5),
    (2.62, 0.30, 4.0),
    (5.26, 0.35, 17.0),
    (4.18, 0.35, 5.5),
    (5.26, 0.35, 17.0),
];

/// Greatest acceleration [rad/s²] and jerk [rad/s³] of each joint.
pub const ACCELERATION: f64 = 10.0;
pub const JERK: f64 = 5000.0;

/// What is kept of a limit of speed for round-off [rad/s], as libfranka does.
const SPARE: f64 = 1e-3;

/// Which part of a limit of speed is demanded at most: what is left is for a clock of the cell that is faster than the robot's.
const DEMANDED: f64 = 0.9;

/// The greatest speed of a joint at `q` \[rad\], away from the middle or towards it [rad/s]: least and greatest velocity.
///
/// ```text
/// dq_max = min(v, max(0, -o + sqrt(2 d (q_max - q))))
/// ```
#[must_use]
pub fn velocities(joint: usize, q: f64) -> (f64, f64) {
    let (least, greatest) = POSITIONS[joint];
    let (speed, kept, deceleration) = SPEEDS[joint];
    let towards = |distance: f64| speed.min((2.0 * deceleration * distance.max(0.0)).sqrt() - kept).max(0.0);
    (-towards(q - least), towards(greatest - q))
}

/// The greatest speed of a joint anywhere [rad/s].
#[must_use]
pub const fn speed(joint: usize) -> f64 {
    SPEEDS[joint].0
}

/// Whether joints may go from `from` to `to` in `duration` \[s\], by the speed that is allowed where they go.
///
/// # Errors
/// The first joint that may not.
pub fn check_speed(from: &Joints, to: &Joints, duration: f64) -> Result<(), CoupledLimit> {
    for joint in 0..JOINTS {
        let velocity = (to[joint] - from[joint]) / duration;
        let (least, greatest) = velocities(joint, to[joint]);
        let limit = DEMANDED * if velocity < 0.0 { least } else { greatest };
        if velocity.abs() > limit.abs() {
            let what = "speed near the end of the range";
            return Err(CoupledLimit { joint, what, excess: Excess::new(velocity, limit, "rad/s") });
        }
    }
    Ok(())
}

/// Whether the robot takes `next` a period after `now`.
///
/// # Errors
/// The first limit that it breaks.
pub fn check(now: &Setpoint, next: &Setpoint) -> Result<(), DriveFault> {
    for (joint, range) in POSITIONS.into_iter().enumerate() {
        let told = |what, actual: f64, (least, greatest): (f64, f64), unit| {
            // What is no number is in no range.
            let is_within = (least..=greatest).contains(&actual);
            let limit = if actual < least { least } else { greatest };
            if is_within {
                return Ok(());
            }
            Err(DriveFault::exceeded(joint, what, Excess::new(actual, limit, unit)))
        };
        let within = |limit: f64| (-limit, limit);
        let (least, greatest) = velocities(joint, now.q[joint]);
        told("position told", next.q[joint], range, "rad")?;
        let (least, greatest) = ((least + SPARE).min(0.0), (greatest - SPARE).max(0.0));
        told("velocity told", next.dq[joint], (least, greatest), "rad/s")?;
        told("acceleration told", next.ddq[joint], within(ACCELERATION), "rad/s²")?;
        let jerk = (next.ddq[joint] - now.ddq[joint]) / PERIOD;
        told("jerk told", jerk, within(JERK), "rad/s³")?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_joint_may_be_fast_only_as_long_as_it_can_still_stop_before_its_limit() {
        // Joint 2: sqrt(5.17 (1.7918 - q)) - 0.2.
        assert_eq!(velocities(1, 0.0).1, 2.62);
        let (least, greatest) = velocities(1, 1.5);
        assert!((greatest - ((5.17 * 0.2918_f64).sqrt() - 0.2)).abs() < 1e-12, "{greatest}");
        assert_eq!(least, -2.62);
        // So near to the limit that nothing is left.
        assert_eq!(velocities(1, 1.7918 - 0.2 * 0.2 / 5.17), (-2.62, 0.0));
        // From greatest speed at its deceleration it stands before the limit.
        for (joint, (speed, _, deceleration)) in SPEEDS.into_iter().enumerate() {
            let mut q = POSITIONS[joint].1 - 2.0;
            let mut v = speed;
            while v > 0.0 {
                v = (v - deceleration * 1e-4).min(velocities(joint, q).1);
                q += v * 1e-4;
            }
            assert!(q <= POSITIONS[joint].1, "joint {joint}: {q}");
        }
    }

    #[test]
    fn what_the_robot_would_not_take_is_refused_with_its_figures() {
        let at = Joints::from([0.0, 0.0, 0.0, -1.5, 0.0, 1.5, 0.0]);
        let now = Setpoint::at_rest(at);
        assert_eq!(check(&now, &now), Ok(()));
        let next = now.after(&Joints::from([0.0, 0.0, 4999.0, 0.0, 0.0, 0.0, 0.0]));
        assert_eq!(check(&now, &next), Ok(()));
        let refused = |next: Setpoint| check(&now, &next).expect_err("too much").what();
        assert_eq!(refused(now.after(&Joints::repeat(5001.0))), "jerk told");
        assert_eq!(refused(Setpoint { ddq: Joints::repeat(10.1), ..now }), "acceleration told");
        assert_eq!(refused(Setpoint { dq: Joints::repeat(2.63), ..now }), "velocity told");
        assert_eq!(refused(Setpoint { q: Joints::zeros(), ..now }), "position told");
        assert_eq!(refused(Setpoint { q: Joints::repeat(f64::NAN), ..now }), "position told");
    }
}
