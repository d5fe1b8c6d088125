//! Arms and what stands around them.

use mrroc::pose::Pose;
use mrroc_robots::clearance::{Capsule, Clearance, ClearanceBuilder, Obstacle, Stop, Stopping};
use mrroc_robots::{Serial, SerialOutline, Six};
use nalgebra::{SVector, Vector3};

const UR: &str = include_str!("../../robots/tests/reference/urdf/three_parallel.urdf");
const SEVEN: &str = include_str!("../../robots/tests/reference/urdf/seven_axes.urdf");

/// A six-axis arm of the size of a UR5, its links 60 mm in radius.
pub(crate) fn six_axes(base: Pose) -> SerialOutline<6> {
    let robot = Serial::<6>::from_urdf(UR, "base", "wrist_3").expect("a chain");
    let robot = robot.with_acceleration(Six::repeat(8.0)).expect("limits").with_base(base);
    SerialOutline::new(robot, 0.06)
}

/// A seven-axis arm with limits of jerk.
pub(crate) fn seven_axes(base: Pose) -> SerialOutline<7> {
    let ends = ends(SEVEN);
    let robot = Serial::<7>::from_urdf(SEVEN, &ends.0, &ends.1).expect("a chain");
    let robot = robot.with_acceleration(SVector::repeat(8.0)).expect("limits");
    let robot = robot.with_jerk(SVector::repeat(400.0)).expect("limits").with_base(base);
    SerialOutline::new(robot, 0.06)
}

/// The first and the last link of a file.
fn ends(urdf: &str) -> (String, String) {
    let names: Vec<&str> = urdf
        .lines()
        .filter_map(|line| line.trim().strip_prefix("<link name=\"")?.split('"').next())
        .collect();
    (names[0].to_owned(), names[names.len() - 1].to_owned())
}

pub(crate) fn stopping() -> Stopping {
    Stopping { reaction: 0.02, stop: Stop::Braking }
}

/// An arm on a table, which reaches along -x where its first joint is at 0, and a box there.
pub(crate) fn around_a_box() -> ClearanceBuilder {
    let obstacle =
        Obstacle::Box { X_WO: Pose::translation(-0.55, -0.1, 0.2), half: Vector3::new(0.1, 0.1, 0.3) };
    Clearance::with_margin(0.02)
        .robot("arm", six_axes(Pose::identity()))
        .expect("an arm")
        .obstacle("table", Obstacle::table(-0.1))
        .expect("a table")
        .obstacle("box", obstacle)
        .expect("a box")
        .ignore(("arm", "link 0"), ("table", "table"))
}

/// The bases of the two arms, which face each other: an arm reaches along the -x of its base.
pub(crate) fn bases() -> [Pose; 2] {
    [Pose::new(Vector3::zeros(), Vector3::z() * core::f64::consts::PI), Pose::translation(0.9, 0.0, 0.0)]
}

/// Two arms that face each other.
pub(crate) fn two_arms() -> ClearanceBuilder {
    let [left, right] = bases();
    Clearance::with_margin(0.02)
        .robot("left", six_axes(left))
        .expect("an arm")
        .robot("right", six_axes(right))
        .expect("an arm")
        .obstacle("table", Obstacle::table(-0.1))
        .expect("a table")
        .tool("left", &[Capsule::new(Vector3::zeros(), Vector3::z() * 0.1, 0.03)])
        .expect("a tool")
}
