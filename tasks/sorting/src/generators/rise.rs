//! Takes the tool up.

use mrroc::prelude::*;
use mrroc_robots::Irp6;
use mrroc_sensors::virtual_sensors::Between;
use nalgebra::Vector3;

use super::chase::Chase;
use crate::places::HIGH;

/// Takes the tool straight up from whatever motion it is in, and is done when it is there at rest. It reads the barrier between the
/// fingers for the program, which asks then whether the part is there.
pub struct Rise {
    chase: Chase,
    /// Where it stops, along and across the belt \[m\].
    place: Option<Vector3<f64>>,
}

impl Rise {
    /// How far it goes on while it stops \[s\].
    const STOPPING: f64 = 0.2;

    /// From the motion that the behaviours leave.
    #[must_use]
    pub fn new(chase: Chase) -> Self {
        Self { chase, place: None }
    }
}

#[generator(ecp)]
impl Rise {
    fn next_step(&mut self, _v: &Reading<(Between,)>, t: Tick) -> Step<Irp6> {
        let tool = self.chase.tool.get();
        let place = *self.place.get_or_insert(Vector3::new(
            tool.at.x + Self::STOPPING * tool.velocity.x,
            tool.at.y,
            HIGH,
        ));
        if (tool.at - place).norm() < 1e-3 && tool.velocity.norm() < 5e-3 {
            return Step::Done;
        }
        self.chase.pursue(place, 0.0, t.dt)
    }
}
