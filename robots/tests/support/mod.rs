//! What the tests of this crate share: a seeded generator of numbers and feasible joint positions.

use mrroc::random::Random;
use mrroc::robot::Robot;
use mrroc_robots::{Irp6, Six};

/// Joint positions that keep joint and motor limits.
pub fn feasible(random: &mut Random, robot: &Irp6) -> Six {
    loop {
        let limits = robot.limits();
        let q = Six::from_fn(|i, _| random.between(limits.lower[i], limits.upper[i]));
        if robot.is_feasible(&q) {
            return q;
        }
    }
}

/// The engraving reference: tool straight down, flange at (0.85, 0, 0.35) in the base of the nominal arm.
pub fn engraving() -> Six {
    let pose = mrroc::pose::Pose::from_parts(
        nalgebra::Translation3::new(0.85, 0.0, 0.35),
        nalgebra::UnitQuaternion::from_matrix(&nalgebra::Matrix3::new(
            1.0, 0.0, 0.0, 0.0, -1.0, 0.0, 0.0, 0.0, -1.0,
        )),
    );
    let near = Six::new(0.0, -1.57, 0.0, 0.0, 1.5 * std::f64::consts::PI, 0.0);
    Irp6::nominal().inverse(&pose, &near).expect("the reference pose is reachable")
}
