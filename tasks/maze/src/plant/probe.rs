//! The touch probe: a virtual sensor that tells whether the ball touches, and where it did.

use std::cell::RefCell;
use std::rc::Rc;

use mrroc::prelude::*;
use mrroc::robot::RobotImage;
use nalgebra::{Vector2, Vector3};

use super::arm::World;
use crate::feeling::{Feeling, Touch};

/// The kind of sensor: a ball on a spring with a switch.
#[derive(Clone, Copy, Debug)]
pub struct TouchProbe;

impl Sensor for TouchProbe {
    const KIND: &'static str = "touch probe";
    type Reading = Touch;
    type Configuration = ();
}

impl<R: Robot> Feeling<R> for TouchProbe {
    fn touch(reading: &Touch) -> Touch {
        *reading
    }

    fn place(_: &Touch, robot: &RobotImage<R>) -> Vector2<f64> {
        robot.demanded().pose.translation.vector.xy()
    }
}

/// Makes readings of the switch.
#[derive(Debug)]
pub struct Probe {
    world: Rc<RefCell<World>>,
    /// Where the encoders saw the ball at the reading before, and when.
    before: Option<(Vector3<f64>, f64)>,
    touch: Touch,
    onset: f64,
}

impl Probe {
    /// The probe of this world.
    #[must_use]
    pub fn new(world: Rc<RefCell<World>>) -> Self {
        Self { world, before: None, touch: Touch::default(), onset: 0.0 }
    }

    /// What the switch tells, with its seat where the encoders see it now [m, W].
    ///
    /// # Errors
    /// The stylus is bent too far.
    pub fn touch(&mut self, seat: &Vector3<f64>) -> Result<Touch, Fault> {
        let world = self.world.borrow();
        world
            .stylus
            .check_travel("the stylus is bent beyond its over-travel: slow down, or look what it hit")?;
        let now = (*seat, world.time);
        let touching = world.last > 0.0 && world.time - world.last <= World::QUIET;
        if world.onset > self.onset {
            self.onset = world.onset;
            // The arm moved evenly since the reading before.
            let (was, then) = self.before.unwrap_or(now);
            let passed = now.1 - then;
            let share = if passed > 0.0 { ((self.onset - then) / passed).clamp(0.0, 1.0) } else { 1.0 };
            let at = was + (now.0 - was) * share;
            self.touch = Touch { touches: self.touch.touches + 1, x: at.x, y: at.y, ..self.touch };
        }
        self.before = Some(now);
        self.touch.touching = touching;
        self.touch.since = world.time - self.onset;
        Ok(self.touch)
    }
}

impl VirtualSensor for Probe {
    type Kind = TouchProbe;

    fn aggregate(&mut self, order: &ReadingOrder<()>) -> Result<Touch, Fault> {
        let arm = order
            .robot
            .ok_or_else(|| Fault::thrown("the touch probe got no state of its arm: write `of`"))?;
        self.touch(&arm.pose.translation.vector)
    }

    fn is_simulated(&self) -> bool {
        true
    }
}
