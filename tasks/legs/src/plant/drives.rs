//! The drives of a leg whose foot may stand on the ground.
//!
//! ```text
//! q -> foot in T -> world -> F on the foot -> J^T F on the joints -> motors -> q
//! ```

use std::cell::RefCell;
use std::rc::Rc;

use mrroc::pose::{Pose, Wrench};
use mrroc_robots::{Simulated, Surrounded, Surroundings};
use nalgebra::Vector3;

use super::world::World;
use crate::leg::Leg;

/// The drives of a leg in the world.
pub type Standing = Surrounded<Leg, 3, OnGround>;

/// Where the foot of a leg is.
#[derive(Debug)]
pub struct OnGround {
    leg: usize,
    world: Rc<RefCell<World>>,
}

/// These drives as those of a leg of the machine, from 0.
#[must_use]
pub fn standing(drives: Simulated<Leg, 3>, leg: usize, world: Rc<RefCell<World>>) -> Standing {
    Surrounded::by(drives, OnGround { leg, world })
}

impl Surroundings<Leg, 3> for OnGround {
    fn begin(&mut self, drives: &mut Simulated<Leg, 3>) {
        let force = self.world.borrow_mut().begin(self.leg);
        drives.push_tool(&Pose::identity(), &Wrench { force, torque: Vector3::zeros() });
    }

    fn end(&mut self, drives: &Simulated<Leg, 3>) {
        self.world.borrow_mut().end(self.leg, drives.state().position);
    }
}
