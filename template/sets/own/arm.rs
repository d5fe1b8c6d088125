//! The kind of robot, and what drives it: three perpendicular slides, until you fill in your own.

use std::time::Duration;

use mrroc::cell_file::Kinds;
use mrroc::prelude::*;
use mrroc::robot::{DriveFault, Driver, JointKind, Limits, Measured, NoInverse};
use nalgebra::Vector3;

/// FILL IN: as many numbers as the robot has joints; `start` in cell.toml has as many.
pub type Joints = Vector3<f64>;

/// The robot's model: its geometry and limits.
#[derive(Clone)]
pub struct Arm {
    base: Pose,
    limits: Limits<Joints>,
}

/// The kinds that `cell.toml` may name. FILL IN: the drives of the real robot in the place of the simulated ones.
pub fn kinds() -> Kinds {
    mrroc_robots::simulated().with("my-arm", |entry| {
        let arm = Arm::at(entry.base());
        let start = entry.start(&arm)?;
        Ok(RobotSetup::new(entry.name(), arm, Slides { position: start, velocity: Joints::zeros() }))
    })
}

impl Arm {
    /// FILL IN: the limits of its joints [m or rad, and per second].
    pub fn at(base: Pose) -> Self {
        let limits = Limits {
            lower: Joints::repeat(-1.0),
            upper: Joints::repeat(1.0),
            velocity: Joints::repeat(0.5),
            acceleration: Joints::repeat(3.0),
            jerk: None,
        };
        Arm { base, limits }
    }
}

impl Robot for Arm {
    const KIND: &'static str = "my-arm";
    type Joints = Joints;

    /// FILL IN: which joints turn and which slide.
    fn joint(&self, _: usize) -> JointKind {
        JointKind::Prismatic
    }

    fn limits(&self) -> &Limits<Joints> {
        &self.limits
    }

    /// FILL IN: where the flange is for joint positions `q`.
    fn forward(&self, q: &Joints) -> Pose {
        self.base * Pose::translation(q.x, q.y, q.z)
    }

    /// FILL IN: the joint positions that put the flange there, those nearest to `near` if there are several.
    #[allow(non_snake_case)]
    fn inverse(&self, X_WF: &Pose, _near: &Joints) -> Result<Joints, NoInverse> {
        let X_BF = self.base.inverse() * X_WF;
        let (actual, tolerance) = (X_BF.rotation.angle(), 1e-6);
        if actual > tolerance {
            let what = "turn of the tool, which slides cannot give";
            return Err(NoInverse::NotAttainable { what, actual, tolerance, unit: "rad" });
        }
        Ok(X_BF.translation.vector)
    }

    /// FILL IN: the frames of the links from the base outwards, for the picture; the flange comes last.
    fn frames(&self, q: &Joints, visit: &mut dyn FnMut(&Pose)) {
        for frame in [[0.0, 0.0, 0.0], [q.x, 0.0, 0.0], [q.x, q.y, 0.0]] {
            visit(&(self.base * Pose::translation(frame[0], frame[1], frame[2])));
        }
        visit(&self.forward(q));
    }
}

/// Simulated drives: a mass on each slide, and a regulator that pulls it to what is demanded.
pub struct Slides {
    position: Joints,
    velocity: Joints,
}

/// The servo period [s], and the stiffness [1/s²] and damping [1/s] of the regulators, per unit of mass.
const SERVO: f64 = 0.001;
const STIFFNESS: f64 = 40_000.0;
const DAMPING: f64 = 400.0;

impl Driver<Arm> for Slides {
    fn period(&self) -> Duration {
        Duration::from_secs_f64(SERVO)
    }

    fn measured(&self) -> Result<Measured<Joints>, DriveFault> {
        Ok(Measured { position: self.position, velocity: self.velocity })
    }

    /// FILL IN: hand `demanded` to the hardware and return what its encoders read.
    fn tick(&mut self, demanded: &Joints) -> Result<Measured<Joints>, DriveFault> {
        let acceleration = (demanded - self.position) * STIFFNESS - self.velocity * DAMPING;
        self.velocity += acceleration * SERVO;
        self.position += self.velocity * SERVO;
        self.measured()
    }
}
