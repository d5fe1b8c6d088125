//! The simulated world as sensors see it.

use core::cell::Cell;
use std::rc::Rc;

use mrroc::pose::Pose;
use mrroc_robots::grasp::{Body, Hand, World};
use mrroc_sensors::scene::{Scene, Solid};
use mrroc_sensors::simulated::solid;
use mrroc_sensors::virtual_sensors::Tool;
use nalgebra::Vector3;

use crate::parts::Arrival;

/// The parts in a world.
#[derive(Clone, Debug)]
pub struct Belt {
    world: World,
    looks: Rc<[Look]>,
}

/// How a part looks.
#[derive(Clone, Debug)]
struct Look {
    hull: Box<[Vector3<f64>]>,
    reflectance: f64,
}

impl Belt {
    /// Of a world into which these parts have been put, in their order.
    #[must_use]
    pub fn new(world: World, parts: &[Arrival]) -> Self {
        Self::of(world, parts.iter().map(|part| (&part.body, part.reflectance)))
    }

    /// Of a world into which these bodies have been put, in their order, with how much light they scatter, 0 to 1.
    #[must_use]
    pub fn of<'b>(world: World, bodies: impl Iterator<Item = (&'b Body, f64)>) -> Self {
        let look = |(body, reflectance): (&Body, f64)| Look { hull: body.points().into(), reflectance };
        Self { world, looks: bodies.map(look).collect() }
    }
}

impl Scene for Belt {
    fn now(&self) -> f64 {
        self.world.time()
    }

    fn each_solid(&self, visit: &mut dyn FnMut(&Solid<'_>)) {
        self.world.each_body(|number, state| {
            let Look { hull, reflectance } = &self.looks[number];
            visit(&solid(hull, *reflectance, state));
        });
    }
}

/// What is between the fingertips of a hand: a beam from one to the other ends there, and what lies in line with it behind a finger,
/// another arm's part for one, does not cover it.
#[derive(Clone, Debug)]
pub struct AtTool {
    belt: Belt,
    hand: Hand,
    /// When and where the tool was at the last two times that were asked for.
    seen: Cell<[(f64, Vector3<f64>); 2]>,
}

impl AtTool {
    /// Between the fingers of this hand.
    #[must_use]
    pub fn new(belt: Belt, hand: Hand) -> Self {
        Self { belt, hand, seen: Cell::default() }
    }
}

impl Scene for AtTool {
    fn now(&self) -> f64 {
        self.belt.now()
    }

    fn each_solid(&self, visit: &mut dyn FnMut(&Solid<'_>)) {
        let tool = self.hand.pose();
        // A hand without fingers is behind none.
        let half = 0.5 * self.hand.opening().unwrap_or(f64::INFINITY);
        self.belt.each_solid(&mut |solid: &Solid<'_>| {
            if reaches_between(&tool, half, solid) {
                visit(solid);
            }
        });
    }
}

/// Whether some of a solid is within `half` \[m\] of the tool's frame E along x of E, from pad to pad.
#[allow(non_snake_case)]
fn reaches_between(X_WE: &Pose, half: f64, solid: &Solid<'_>) -> bool {
    let x_E = X_WE.rotation * Vector3::x();
    let middle = x_E.dot(&(solid.pose.translation.vector - X_WE.translation.vector));
    // x of E in the solid's frame: its points need not be turned.
    let x_B = solid.pose.rotation.inverse_transform_vector(&x_E);
    let along = |point: &Vector3<f64>| middle + x_B.dot(point);
    solid.hull.iter().any(|point| along(point) <= half)
        && solid.hull.iter().any(|point| along(point) >= -half)
}

impl Tool for AtTool {
    /// It has moved evenly for a short time.
    fn pose_before(&self, before: f64) -> Pose {
        let mut pose = self.hand.pose();
        let now = (self.now(), pose.translation.vector);
        let [mut earlier, mut last] = self.seen.get();
        if now.0 > last.0 {
            (earlier, last) = (last, now);
            self.seen.set([earlier, last]);
        }
        let passed = last.0 - earlier.0;
        if passed > 0.0 && passed < 0.1 {
            pose.translation.vector -= (last.1 - earlier.1) * (before / passed);
        }
        pose
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A cube of 40 mm, its middle so far along x of E, which is turned by 0.3 rad.
    fn is_between(off: f64, half: f64) -> bool {
        let tool = Pose::translation(0.7, 0.2, 0.02) * Pose::rotation(Vector3::z() * 0.3);
        let hull: Vec<Vector3<f64>> = (0..8)
            .map(|i| {
                let side = |bit: usize| if i & bit == 0 { -0.02 } else { 0.02 };
                Vector3::new(side(1), side(2), side(4))
            })
            .collect();
        let pose = tool * Pose::translation(off, 0.0, 0.0);
        let still = Vector3::zeros();
        let solid = Solid { hull: &hull, pose, velocity: still, angular_velocity: still, reflectance: 1.0 };
        reaches_between(&tool, half, &solid)
    }

    #[test]
    fn what_lies_behind_a_finger_is_not_between_the_fingers() {
        // Pads at 40 mm: the cube reaches between them up to 60 mm off their middle.
        for off in [0.0, 0.019, 0.0599] {
            assert!(is_between(off, 0.04) && is_between(-off, 0.04), "{off} m");
        }
        for off in [0.0601, 0.2, 2.1] {
            assert!(!is_between(off, 0.04) && !is_between(-off, 0.04), "{off} m");
        }
        assert!(is_between(2.1, f64::INFINITY));
        // Gripped, the pads are at its faces.
        assert!(is_between(0.0, 0.02));
    }
}
