//! A two-finger gripper with parallel fingers, by the figures of a Robotiq 2F-85: one joint, a robot of its own.
//!
//! ```text
//!        o-------+-------o         x: opening between the fingers, 0..0.085 m
//!        |       | z_B   |
//!        |       |       |   z_F   B: on the flange's axis between the fingers
//!        |       B--> x_B F        F: the finger at +x/2, axes as B; the other mirrors it
//! ```
//!
//! **Joint.** `x`, the opening \[m\]. **Inverse.** As that of [`Gripper`](crate::Gripper). The fingers of the real gripper
//! also come forward by some millimetres when they close; the model leaves that out.
//!
//! **Grasp.** An object stops the fingers short of their demand: that is no fault, and what presses on it is the drive's
//! limited current. `Simulated::block` stands for the object.
//!
//! Sources: the manufacturer's figures (stroke; speeds of 20 to 150 mm/s). The velocity limit leaves a third of that for
//! the fingers to catch up; acceleration and motor are assumed.

use mrroc::prelude::*;
use mrroc::robot::{CoupledLimit, JointKind, Limits, Load, Measured, NoInverse, Tool};
use nalgebra::{Translation3, Vector3};

use crate::dynamics::{Segment, Tree};
use crate::models::base::Base;
use crate::models::drives::{Driven, MotorData, MotorLimits, Shafts, check_motors, motor_limits_in_words};
use crate::models::gripper::Gripper;
use crate::models::kinematics::{Jacobian, Kinematics, column, position_along_x};
use crate::models::urdf::export::exported;
use crate::models::vectors::One;

/// A two-finger gripper with an opening of 85 mm.
#[derive(Clone, Debug, PartialEq)]
pub struct TwoFingers {
    base: Base,
    limits: Limits<One>,
}

impl TwoFingers {
    /// The widest opening \[m\].
    pub const STROKE: f64 = 0.085;
    /// Largest distance of a demanded pose from the nearest one that the finger attains \[m or rad\].
    pub const OFF: f64 = 1e-6;
    /// Motor angle per opening [rad/m] (assumed).
    pub const GEAR: f64 = 3500.0;
    /// Mass of a finger \[kg\] (assumed).
    pub const FINGER: f64 = 0.1;
    /// The drive: that of the IRp-6's gripper (assumed).
    pub const MOTOR: MotorData = Gripper::MOTOR;
    const MOTOR_LIMITS: MotorLimits<1> = MotorLimits { lower: [-50.0], upper: [350.0], speed: 700.0 };

    /// The gripper with its base at the world's origin.
    #[must_use]
    pub fn new() -> Self {
        Self {
            base: Base::default(),
            limits: Limits {
                lower: One::new(0.0),
                upper: One::new(Self::STROKE),
                velocity: One::new(0.1),
                acceleration: One::new(0.4),
                jerk: None,
            },
        }
    }

    /// The same gripper whose fingers open by this much at most \[m\], > 0, at most [`STROKE`](Self::STROKE).
    #[must_use]
    pub fn with_stroke(mut self, stroke: f64) -> Self {
        self.limits.upper = One::new(stroke);
        self
    }

    /// The same gripper with its base at `X_WB` in the world.
    #[must_use]
    #[allow(non_snake_case)]
    pub fn with_base(self, X_WB: Pose) -> Self {
        Self { base: Base::at(X_WB), ..self }
    }
}

impl Default for TwoFingers {
    fn default() -> Self {
        Self::new()
    }
}

impl Robot for TwoFingers {
    const KIND: &'static str = "two fingers";

    type Joints = One;

    fn joint(&self, _i: usize) -> JointKind {
        JointKind::Prismatic
    }

    fn limits(&self) -> &Limits<One> {
        &self.limits
    }

    fn coupled_limits(&self) -> Vec<String> {
        motor_limits_in_words(self)
    }

    fn check_coupled(&self, from: &One, to: &One, duration: f64) -> Result<(), CoupledLimit> {
        check_motors(self, from, to, duration)
    }

    fn forward(&self, q: &One) -> Pose {
        self.base.X_WB * Translation3::new(0.5 * q[0], 0.0, 0.0)
    }

    /// Visits the frames `X_WL`: B, the other finger, the finger F.
    fn frames(&self, q: &One, visit: &mut dyn FnMut(&Pose)) {
        visit(&self.base.X_WB);
        visit(&(self.base.X_WB * Translation3::new(-0.5 * q[0], 0.0, 0.0)));
        visit(&self.forward(q));
    }

    #[allow(non_snake_case)]
    fn inverse(&self, X_WF: &Pose, _near: &One) -> Result<One, NoInverse> {
        position_along_x(&(self.base.X_BW * X_WF), Self::OFF).map(|position| One::new(2.0 * position))
    }

    fn urdf(&self, name: &str, tool: &Tool) -> Option<String> {
        exported(self, name, tool)
    }
}

/// One solution. The one column is 1/2: no posture is singular.
impl Kinematics<1> for TwoFingers {
    fn reach(&self) -> f64 {
        self.limits.upper[0]
    }

    fn jacobian(&self, _q: &One) -> Jacobian<1> {
        column(&(self.base.X_WB.rotation * Vector3::x() * 0.5), &Vector3::zeros())
    }

    #[allow(non_snake_case)]
    fn solutions(&self, X_WF: &Pose, near: &One, visit: &mut dyn FnMut(&One)) -> Result<(), NoInverse> {
        visit(&self.inverse(X_WF, near)?);
        Ok(())
    }
}

impl Driven<1> for TwoFingers {
    fn motor_data(&self) -> &[MotorData; 1] {
        &[Self::MOTOR]
    }

    fn motor_limits(&self) -> &MotorLimits<1> {
        &Self::MOTOR_LIMITS
    }

    fn motors(&self, q: &One) -> One {
        q * Self::GEAR
    }

    /// The other finger mirrors it: in the frame of that one, this one stands at x.
    fn tree(&self) -> Option<Tree<1>> {
        let mass = Load::point(Self::FINGER, Vector3::zeros());
        let other = Segment::sliding("other_finger", None, 0, Vector3::zeros(), Vector3::x());
        let finger = Segment::sliding("finger", Some(0), 0, Vector3::zeros(), Vector3::x());
        let fingers = vec![other.following(-0.5).carrying(mass), finger.carrying(mass)];
        Tree::new(self.base.X_WB, fingers, Pose::identity()).ok()
    }

    fn shafts(&self, angles: &One, speeds: &One) -> Shafts<1> {
        let joints = Measured { position: angles / Self::GEAR, velocity: speeds / Self::GEAR };
        Shafts { joints, loads: One::zeros() }
    }
}
