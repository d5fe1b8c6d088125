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
#[generator(ecp, first = begin)]
fn point_to_point(c: &mut PointToPoint, t: Tick) -> Step<Arm> {
    if c.t >= DURATION {
        return Step::Done;
    }
    c.t = (c.t + t.dt).min(DURATION);
    // FILL IN: how far along the motion is at c.t; this share of it begins and ends at rest.
    let u = c.t / DURATION;
    let share = u * u * (3.0 - 2.0 * u);
    Step::Next(Demand::pose(Translation3::from(c.offset * share) * c.from))
}

/// The first step: the one place that needs to know where the arm is.
fn begin(c: &mut PointToPoint, e: &State<Arm>, t: Tick) -> Step<Arm> {
    c.from = e.demanded().pose;
    point_to_point(c, t)
}
