//! What the tests of this crate share: a seeded generator of numbers and feasible joint positions.

use mrroc::robot::Robot;
use mrroc_robots::{Irp6, Six};

/// SplitMix64 (Steele, Lea, Flood 2014).
pub struct Random(pub u64);

impl Random {
    /// The next number in `lower..upper`.
    pub fn between(&mut self, lower: f64, upper: f64) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        let unit = ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64;
        lower + (upper - lower) * unit
    }

    /// Joint positions that keep joint and motor limits.
    pub fn feasible(&mut self, robot: &Irp6) -> Six {
        loop {
            let limits = robot.limits();
            let q = Six::from_fn(|i, _| self.between(limits.lower[i], limits.upper[i]));
            if robot.is_feasible(&q) {
                return q;
            }
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
