//! The arms of tests and of the bench of several arms.

use mrroc::pose::Pose;
use mrroc_robots::clearance::{Stop, Stopping};
use mrroc_robots::{Serial, SerialOutline, Six};
use nalgebra::SVector;

const UR: &str = include_str!("../../robots/tests/reference/urdf/three_parallel.urdf");
const SEVEN: &str = include_str!("../../robots/tests/reference/urdf/seven_axes.urdf");

/// The radius of all links \[m\].
const RADIUS: f64 = 0.06;

/// A six-axis arm of the size of a UR5.
pub(crate) fn six_axes_model(base: Pose) -> Serial<6> {
    let robot = Serial::<6>::from_urdf(UR, "base", "wrist_3").expect("a chain");
    robot.with_acceleration(Six::repeat(8.0)).expect("limits").with_base(base)
}

/// The same with what it fills.
pub(crate) fn six_axes(base: Pose) -> SerialOutline<6> {
    SerialOutline::new(six_axes_model(base), RADIUS)
}

/// The same with a limit of jerk of all joints [rad/s³].
pub(crate) fn six_axes_with_jerk(base: Pose, jerk: f64) -> SerialOutline<6> {
    let robot = six_axes_model(base).with_jerk(Six::repeat(jerk)).expect("limits");
    SerialOutline::new(robot, RADIUS)
}

/// A seven-axis arm with limits of jerk.
pub(crate) fn seven_axes_model(base: Pose) -> Serial<7> {
    let robot = Serial::<7>::from_urdf(SEVEN, "world_foot", "flange").expect("a chain");
    let robot = robot.with_acceleration(SVector::repeat(8.0)).expect("limits");
    robot.with_jerk(SVector::repeat(400.0)).expect("limits").with_base(base)
}

/// The same with what it fills.
pub(crate) fn seven_axes(base: Pose) -> SerialOutline<7> {
    SerialOutline::new(seven_axes_model(base), RADIUS)
}

/// The same with jerk of the size of a Panda's.
pub(crate) fn seven_quick_axes(base: Pose) -> SerialOutline<7> {
    let robot = seven_axes_model(base).with_jerk(SVector::repeat(5000.0)).expect("limits");
    SerialOutline::new(robot, RADIUS)
}

pub(crate) fn stopping() -> Stopping {
    Stopping { reaction: 0.02, stop: Stop::Braking }
}
