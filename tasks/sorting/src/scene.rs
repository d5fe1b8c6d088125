//! The simulated world as sensors see it.

use core::cell::Cell;
use std::rc::Rc;

use mrroc::pose::Pose;
use mrroc_robots::grasp::{Body, Hand, World};
use mrroc_sensors::scene::{Scene, Solid};
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
            visit(&Solid {
                hull,
                pose: state.pose,
                velocity: state.velocity,
                angular_velocity: state.angular_velocity,
                reflectance: *reflectance,
            });
        });
    }
}

/// The same with the tool at which a sensor is.
#[derive(Clone, Debug)]
pub struct AtTool {
    belt: Belt,
    hand: Hand,
    /// When and where the tool was at the last two times that were asked for.
    seen: Cell<[(f64, Vector3<f64>); 2]>,
}

impl AtTool {
    /// A beam between fingertips ends there: only what is so near counts, not what another arm carries in line with it \[m\].
    const NEAR: f64 = 0.2;

    /// At the tool of this hand.
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
        let tool = self.hand.pose().translation.vector;
        self.belt.each_solid(&mut |solid: &Solid<'_>| {
            if (solid.pose.translation.vector - tool).norm() < AtTool::NEAR {
                visit(solid);
            }
        });
    }
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
