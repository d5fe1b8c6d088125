//! The simulated world as the camera sees it: parts, and the arm where it comes into view.

use std::cell::RefCell;
use std::rc::Rc;

use mrroc::pose::Pose;
use mrroc_robots::clearance::Outline;
use mrroc_robots::grasp::World;
use mrroc_robots::{Irp6, Shaft};
use mrroc_sensors::form::{Form, Piece};
use mrroc_sensors::scene::{Scene, Solid};
use mrroc_sensors::view::{Seen, View};
use nalgebra::{Point3, Vector3};

use super::arrivals::Coming;
use super::layout::X_WF;
use crate::scene::Belt;

/// What a camera and the barrier that triggers it see.
#[derive(Clone, Debug)]
#[allow(non_snake_case)]
pub struct Sight {
    world: World,
    belt: Belt,
    parts: Rc<[Coming]>,
    arm: Irp6,
    shaft: Rc<RefCell<Option<Shaft>>>,
    X_FW: Pose,
}

impl Sight {
    /// Of a world into which these parts have been put, with the arm of these joints.
    #[must_use]
    pub fn of(world: World, parts: Rc<[Coming]>, shaft: Rc<RefCell<Option<Shaft>>>) -> Self {
        let belt = Belt::of(world.clone(), parts.iter().map(|part| (&part.body, part.reflectance)));
        Self { world, belt, parts, arm: Irp6::nominal(), shaft, X_FW: X_WF().inverse() }
    }
}

impl Scene for Sight {
    fn now(&self) -> f64 {
        self.world.time()
    }

    fn each_solid(&self, visit: &mut dyn FnMut(&Solid<'_>)) {
        self.belt.each_solid(visit);
    }
}

impl View for Sight {
    fn each_form(&self, visit: &mut dyn FnMut(&Seen<'_>)) {
        let to_belt = &self.X_FW.rotation;
        self.world.each_body(|number, state| {
            let part = &self.parts[number];
            let lever = state.pose.rotation * part.X_BP.translation.vector;
            let velocity = state.velocity + state.angular_velocity.cross(&lever);
            visit(&Seen {
                form: &part.form,
                pose: part.place(&state.pose),
                velocity: to_belt * velocity,
                angular_velocity: to_belt * state.angular_velocity,
                reflectance: part.reflectance,
            });
        });
        let Some(q) = self.shaft.borrow().as_ref().map(|shaft| shaft.state().position) else { return };
        self.arm.capsules(&q, &mut |capsule| {
            let ends = capsule.ends.map(|end| (self.X_FW * Point3::from(end)).coords);
            let form = Form::new([Piece::Capsule { ends, radius: capsule.radius }]);
            visit(&Seen {
                form: &form,
                pose: Pose::identity(),
                velocity: Vector3::zeros(),
                angular_velocity: Vector3::zeros(),
                reflectance: 0.4,
            });
        });
    }

    fn surface(&self, before: f64) -> f64 {
        let Some(mark) = self.world.belt_mark(0) else { return 0.0 };
        let at = self.X_FW * Point3::from(mark.pose.translation.vector);
        at.x - (self.X_FW.rotation * mark.velocity).x * before
    }
}
