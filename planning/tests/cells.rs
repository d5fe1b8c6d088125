//! Arms and what stands around them.

use mrroc::pose::Pose;
use mrroc::random::Random;
use mrroc_robots::SerialOutline;
use mrroc_robots::clearance::{Capsule, Clearance, ClearanceBuilder, Obstacle};
use nalgebra::Vector3;

pub(crate) use super::models::{seven_axes, six_axes, six_axes_with_jerk, stopping};

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

/// Positions of the two arms, which reach for each other.
pub(crate) fn draw_two(random: &mut Random) -> Vec<f64> {
    let draw = |j: usize| match j % 6 {
        0 => random.within(0.8),
        1 => random.between(-1.4, -0.2),
        2 => random.between(0.0, 1.8),
        _ => random.within(1.8),
    };
    (0..12).map(draw).collect()
}

/// A seven-axis arm, which has limits of jerk, and a ball in front of it.
pub(crate) fn around_a_ball() -> ClearanceBuilder {
    Clearance::with_margin(0.02)
        .robot("arm", seven_axes(Pose::identity()))
        .expect("an arm")
        .obstacle("ball", Obstacle::ball(Vector3::new(0.45, 0.0, 0.45), 0.15))
        .expect("a ball")
        .ignore_own("arm")
}

/// What is planned.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Kind {
    AroundABox,
    TwoArms,
    /// With limits of jerk.
    SevenAxes,
}

impl Kind {
    pub(crate) fn world(self) -> ClearanceBuilder {
        match self {
            Kind::AroundABox => around_a_box(),
            Kind::TwoArms => two_arms(),
            Kind::SevenAxes => around_a_ball(),
        }
    }
}

/// Two arms that face each other.
pub(crate) fn two_arms() -> ClearanceBuilder {
    two_arms_of(six_axes)
}

/// Two that have this shape at their bases.
pub(crate) fn two_arms_of(arm: impl Fn(Pose) -> SerialOutline<6>) -> ClearanceBuilder {
    let [left, right] = bases();
    Clearance::with_margin(0.02)
        .robot("left", arm(left))
        .expect("an arm")
        .robot("right", arm(right))
        .expect("an arm")
        .obstacle("table", Obstacle::table(-0.1))
        .expect("a table")
        .tool("left", &[Capsule::new(Vector3::zeros(), Vector3::z() * 0.1, 0.03)])
        .expect("a tool")
}
