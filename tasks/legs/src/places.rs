//! Where the legs are on the trunk, and how they begin.
//!
//! Frames: W world, z up; T the trunk, x ahead, y to the left, its origin in the middle of the four hips. Programs believe that the trunk
//! begins over the origin of W, along its axes.

use mrroc::pose::Pose;
use nalgebra::Vector3;

use crate::leg::{Leg, Three};
use crate::walk::Gait;

/// The legs' names, left and right in front, left and right behind. Lists of legs are in this order.
pub const NAMES: [&str; 4] = ["lf", "rf", "lh", "rh"];
/// The hips are so far ahead of the trunk's middle, or behind it, and so far aside \[m\].
pub const HIP: [f64; 2] = [0.3, 0.11];
/// A posture on the branch of all others \[rad\].
pub const NEAR: Three = Three::new(0.0, 0.7, -1.4);

/// `X_TB`, the hip of a leg.
#[must_use]
pub fn hip(leg: usize) -> Pose {
    let ahead = if leg < 2 { HIP[0] } else { -HIP[0] };
    let left = if leg.is_multiple_of(2) { HIP[1] } else { -HIP[1] };
    Pose::translation(ahead, left, 0.0)
}

/// Where a foot is right below its leg, so far below the hip [m, T].
#[must_use]
pub fn below(leg: usize, height: f64) -> Vector3<f64> {
    let hip = hip(leg).translation.vector;
    Vector3::new(hip.x, hip.y + Leg::ASIDE.copysign(hip.y), -height)
}

/// Where the feet begin [m, T]: as they stand when the first leg is about to be lifted.
#[must_use]
pub fn stance(gait: &Gait) -> [Vector3<f64>; 4] {
    core::array::from_fn(|leg| below(leg, gait.height) + Vector3::x() * gait.ahead_at_start(leg))
}

/// The posture at the start \[rad\], that of `cell.toml`.
#[must_use]
pub fn start() -> [Three; 4] {
    let feet = stance(&Gait::default());
    core::array::from_fn(|leg| {
        let q = Leg::at(hip(leg)).reach_for(&feet[leg], &NEAR).unwrap_or(NEAR);
        // As written there, to 1e-6 rad.
        q.map(|angle| (angle * 1e6).round() / 1e6)
    })
}
