//! From point to point.

use mrroc::prelude::*;
use nalgebra::{Translation3, Vector3};

use crate::arm::Arm;

/// How long the motion takes [s].
const DURATION: f64 = 2.0;

/// Moves the tool by an offset in the world, from rest to rest.
pub struct PointToPoint {
    offset: Vector3<f64>,
    from: Pose,
    t: f64,
}

impl PointToPoint {
    /// By so many metres.
    pub fn by(x: f64, y: f64, z: f64) -> Self {
        PointToPoint { offset: Vector3::new(x, y, z), from: Pose::identity(), t: 0.0 }
    }
}

/// One step: what is returned is demanded.
// ANCHOR: step
#[generator(mp, first = begin)]
fn point_to_point(c: &mut PointToPoint, t: Tick) -> Step<(Arm,)> {
    if c.t >= DURATION {
        return Step::Done;
    }
    c.t = (c.t + t.dt).min(DURATION);
    let u = c.t / DURATION;
    let angle = std::f64::consts::TAU * u * u * (3.0 - 2.0 * u); // begins and ends at rest
    let along = c.offset * (0.5 - 0.5 * angle.cos()); // the offset is the circle's diameter
    let aside = Vector3::y() * (0.5 * c.offset.z * angle.sin());
    Step::Next((Demand::pose(Translation3::from(along + aside) * c.from),))
}
// ANCHOR_END: step

/// The first step: the one place that needs to know where the arm is.
fn begin(c: &mut PointToPoint, e: &State<(Arm,)>, t: Tick) -> Step<(Arm,)> {
    c.from = e.0.demanded().pose;
    point_to_point(c, t)
}
