//! From point to point, two robots together.

use mrroc::prelude::*;
use nalgebra::{Translation3, Vector3};

use crate::arm::Arm;

/// How long the motion takes [s].
const DURATION: f64 = 2.0;

/// Moves both tools by the same offset in the world, from rest to rest.
pub struct PointToPoint {
    offset: Vector3<f64>,
    from: [Pose; 2],
    t: f64,
}

impl PointToPoint {
    /// By so many metres.
    pub fn by(x: f64, y: f64, z: f64) -> Self {
        PointToPoint { offset: Vector3::new(x, y, z), from: [Pose::identity(); 2], t: 0.0 }
    }
}

/// One step: what is returned is demanded, of each robot in the order of the list.
#[generator(mp, first = begin)]
fn point_to_point(c: &mut PointToPoint, t: Tick) -> Step<(Arm, Arm)> {
    if c.t >= DURATION {
        return Step::Done;
    }
    c.t = (c.t + t.dt).min(DURATION);
    // FILL IN: how far along the motion is at c.t; this share of it begins and ends at rest.
    let u = c.t / DURATION;
    let share = u * u * (3.0 - 2.0 * u);
    let moved = Translation3::from(c.offset * share);
    let [left, right] = c.from;
    Step::Next((Demand::pose(moved * left), Demand::pose(moved * right)))
}

/// The first step: the one place that needs to know where the robots are.
fn begin(c: &mut PointToPoint, e: &State<(Arm, Arm)>, t: Tick) -> Step<(Arm, Arm)> {
    c.from = [e.0.demanded().pose, e.1.demanded().pose];
    point_to_point(c, t)
}
