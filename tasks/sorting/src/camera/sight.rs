//! The simulated world as the camera sees it: parts, and the arm where it comes into view.

use std::cell::RefCell;
use std::rc::Rc;

use mrroc::pose::Pose;
use mrroc_robots::clearance::Outline;
use mrroc_robots::grasp::World;
use mrroc_robots::{Irp6, Shaft};
use mrroc_sensors::form::{Form, Piece};
use mrroc_sensors::scene::{Scene, Solid};
use mrroc_sensors::simulated::OverBelt;
use mrroc_sensors::view::{Seen, View};
use nalgebra::{Point3, Vector3};

use super::arrivals::Coming;
use super::layout::X_WF;

/// What a camera and the barrier that triggers it see.
#[derive(Clone, Debug)]
#[allow(non_snake_case)]
pub struct Sight {
    parts: OverBelt,
    arm: Irp6,
    shaft: Rc<RefCell<Option<Shaft>>>,
    X_FW: Pose,
}

impl Sight {
    /// Of a world into which these parts have been put, with the arm of these joints.
    #[must_use]
    pub fn of(world: World, parts: &[Coming], shaft: Rc<RefCell<Option<Shaft>>>) -> Self {
        let parts = OverBelt::with(world, X_WF(), parts.iter().map(Coming::piece));
        Self { parts, arm: Irp6::nominal(), shaft, X_FW: X_WF().inverse() }
    }
}

impl Scene for Sight {
    fn now(&self) -> f64 {
        self.parts.now()
    }

    fn each_solid(&self, visit: &mut dyn FnMut(&Solid<'_>)) {
        self.parts.each_solid(visit);
    }
}

impl View for Sight {
    fn each_form(&self, visit: &mut dyn FnMut(&Seen<'_>)) {
        self.parts.each_form(visit);
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
        self.parts.surface(before)
    }
}
