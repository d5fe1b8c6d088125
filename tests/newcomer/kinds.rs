//! A robot of one's own, as it is and with the mistakes that one makes.

use mrroc::cell_file::{Kinds, RobotEntry};
use mrroc::prelude::*;
use mrroc::robot::{DriveFault, Driver, JointKind, Limits, Measured, NoInverse};
use mrroc_tests::{ExactDrive, MS, Q};

/// Three perpendicular slides.
#[derive(Clone)]
pub struct Slides {
    limits: Limits<Q<3>>,
    /// What `inverse` makes of x: 1, or -1 after a mistake.
    sign: f64,
}

impl Slides {
    pub fn new() -> Slides {
        let limits = Limits {
            lower: Q::repeat(-1.0),
            upper: Q::repeat(1.0),
            velocity: Q::repeat(0.5),
            acceleration: Q::repeat(3.0),
            jerk: None,
        };
        Slides { limits, sign: 1.0 }
    }

    pub fn inverted() -> Slides {
        Slides { sign: -1.0, ..Slides::new() }
    }

    pub fn without_speed() -> Slides {
        let mut slides = Slides::new();
        slides.limits.velocity[1] = 0.0;
        slides
    }

    pub fn with_jerk() -> Slides {
        let mut slides = Slides::new();
        slides.limits.jerk = Some(Q::repeat(50.0));
        slides
    }

    pub fn with_weak_brakes() -> Slides {
        let mut slides = Slides::new();
        slides.limits.acceleration[2] = 0.5;
        slides
    }
}

impl Robot for Slides {
    const KIND: &'static str = "slides";
    type Joints = Q<3>;

    fn joint(&self, _: usize) -> JointKind {
        JointKind::Prismatic
    }

    fn limits(&self) -> &Limits<Q<3>> {
        &self.limits
    }

    fn forward(&self, q: &Q<3>) -> Pose {
        Pose::translation(q.x, q.y, q.z)
    }

    #[allow(non_snake_case)]
    fn inverse(&self, X_WF: &Pose, _: &Q<3>) -> Result<Q<3>, NoInverse> {
        let mut q = X_WF.translation.vector;
        q.x *= self.sign;
        Ok(q)
    }
}

/// Drives that never move.
struct Stuck(Q<3>);

impl Driver<Slides> for Stuck {
    fn period(&self) -> std::time::Duration {
        MS
    }

    fn measured(&self) -> Result<Measured<Q<3>>, DriveFault> {
        Ok(Measured { position: self.0, velocity: Q::zeros() })
    }

    fn tick(&mut self, _: &Q<3>) -> Result<Measured<Q<3>>, DriveFault> {
        Ok(Measured { position: self.0, velocity: Q::zeros() })
    }
}

/// The kinds of a task project: the simulated ones, and slides.
pub fn kinds() -> Kinds {
    with(Slides::new, true)
}

/// The same with other slides, whose drives follow or do not.
pub fn with(slides: fn() -> Slides, follow: bool) -> Kinds {
    mrroc_robots::simulated().with("slides", move |entry: &RobotEntry| -> Result<_, CellError> {
        let robot = slides();
        let start = entry.start(&robot)?;
        Ok(if follow {
            RobotSetup::new(entry.name(), robot, ExactDrive::new(start, MS))
        } else {
            RobotSetup::new(entry.name(), robot, Stuck(start))
        })
    })
}
