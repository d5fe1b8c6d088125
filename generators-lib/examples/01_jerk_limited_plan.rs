//! A plan of three joints that start and arrive together, in the shortest time that their limits of velocity,
//! acceleration and jerk allow; and the same motion slowed down to a given time.
//!
//! `cargo run -p mrroc-examples --example 01_jerk_limited_plan`

use mrroc_generators::jerk::{JerkError, JointLimits, JointState, JointTarget, SynchronisedMove};
use nalgebra::Vector3;

/// Limit of each joint's velocity [rad/s].
pub const VELOCITY: f64 = 0.8;
/// Limit of each joint's acceleration [rad/s^2].
pub const ACCELERATION: f64 = 2.0;
/// Limit of each joint's jerk [rad/s^3].
pub const JERK: f64 = 20.0;

/// Where the joints are to go from 0 [rad].
const GOAL: Vector3<f64> = Vector3::new(1.0, -0.4, 0.2);

/// From rest to rest, in at least `minimum` seconds.
pub fn plan(minimum: f64) -> Result<SynchronisedMove<Vector3<f64>>, JerkError> {
    let limits = JointLimits {
        velocity: Vector3::repeat(VELOCITY),
        acceleration: Vector3::repeat(ACCELERATION),
        jerk: Vector3::repeat(JERK),
    };
    let start = JointState::rest(Vector3::zeros());
    SynchronisedMove::with_minimum_duration(&start, &JointTarget::rest(GOAL), &limits, minimum)
}

/// Runs the example.
///
/// # Errors
/// When a number is out of range.
pub fn main() -> Result<(), JerkError> {
    let fastest = plan(0.0)?;
    println!("the joints arrive together after {:.3} s", fastest.duration());
    // Joint 1 has the largest displacement: T = D / V + V / A + A / J.
    let expected = GOAL[0] / VELOCITY + VELOCITY / ACCELERATION + ACCELERATION / JERK;
    assert!((fastest.duration() - expected).abs() < 1e-12);

    // Within the limits throughout, exactly at the goal in the end, and straight there.
    for joint in 0..3 {
        let peaks = fastest.peaks(joint).expect("there are three joints");
        let largest = |(high, low): (f64, f64)| high.max(-low);
        assert!(largest(peaks.velocity) <= VELOCITY + 1e-12);
        assert!(largest(peaks.acceleration) <= ACCELERATION + 1e-12);
        assert!(largest(peaks.jerk) <= JERK + 1e-12);
    }
    assert_eq!(fastest.at(fastest.duration()).position, GOAL);
    let middle = fastest.at(0.3 * fastest.duration()).position;
    assert!((middle - GOAL * middle[0] / GOAL[0]).norm() < 1e-12);

    // In twice the time: half the velocity, a quarter of the acceleration, an eighth of the jerk.
    let slow = plan(2.0 * fastest.duration())?;
    assert_eq!(slow.duration(), 2.0 * fastest.duration());
    for t in [0.05, 0.4, 1.3] {
        let quick = fastest.at(t);
        let here = slow.at(2.0 * t);
        assert!((here.position - quick.position).norm() < 1e-12);
        assert!((here.velocity * 2.0 - quick.velocity).norm() < 1e-12);
        assert!((here.acceleration * 4.0 - quick.acceleration).norm() < 1e-12);
        assert!((here.jerk * 8.0 - quick.jerk).norm() < 1e-9);
    }
    Ok(())
}
