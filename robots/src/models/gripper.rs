//! The two-finger gripper of the IRp-6: one joint, driven with limited current, a robot of its own.
//!
//! ```text
//!        o-------+-------o         x: opening between the fingers, 0.053..0.091 m
//!        |       | z_B   |
//!        |       |       |   z_F   B: on the flange's axis between the fingers
//!        |       B--> x_B F        F: the finger at +x/2, axes as B; the other mirrors it
//! ```
//!
//! **Joint.** `x`, the opening \[m\]. **Inverse.** A pose of the finger is attained when it is B shifted along x_B; one that
//! is off by more than [`Gripper::OFF`] \[m or rad\] is refused.
//!
//! **Grasp.** The drive gives at most 0.2 A (MRROC++) and does not trip when the finger is stopped by an object: the
//! opening that is demanded beyond it presses the fingers together. `Simulated::block` stands for the object.
//!
//! Sources: MRROC++ public facts (opening from motor angle, ranges, encoder, gains, current). Speed, acceleration and the
//! motor's constants are assumed.

use core::f64::consts::TAU;

use mrroc::prelude::*;
use mrroc::robot::{CoupledLimit, JointKind, Limits, Load, Measured, NoInverse, Tool};
use nalgebra::{Translation3, Vector3};

use crate::dynamics::{Segment, Tree};
use crate::models::base::Base;
use crate::models::drives::{
    Driven, Encoder, Gains, MotorData, MotorLimits, Overload, Shafts, check_motors, motor_limits_in_words,
};
use crate::models::kinematics::{Jacobian, Kinematics, column, position_along_x};
use crate::models::urdf::export::exported;
use crate::models::vectors::One;

/// Opening at motor angle 0 \[m\], and its linear [m/rad] and quadratic [m/rad²] terms, both negative (MRROC++).
const OPENING: [f64; 3] = [0.074, 1.451_910_074e-5, 2.8313e-9];

/// A two-finger gripper.
#[derive(Clone, Debug, PartialEq)]
pub struct Gripper {
    base: Base,
    limits: Limits<One>,
}

impl Gripper {
    /// Largest distance of a demanded pose from the nearest one that the finger attains \[m or rad\].
    pub const OFF: f64 = 1e-6;
    /// Mass of a finger \[kg\] (assumed).
    pub const FINGER: f64 = 0.2;
    /// The drive: encoder, gains and current are facts, the rest assumed.
    pub const MOTOR: MotorData = MotorData {
        encoder: Encoder { pulses: 128.0 },
        gains: Gains { a: 0.39, b0: 4.31, b1: 3.945, feedforward: 0.35 },
        current_limit: 0.2,
        resistance: 60.0,
        torque_constant: 0.02,
        inertia: 4e-7,
        viscous: 1e-8,
        coulomb: 2e-4,
        following: TAU,
        brake: 2e4,
        overload: Overload::Limit,
    };
    const MOTOR_LIMITS: MotorLimits<1> = MotorLimits { lower: [-2000.0], upper: [5000.0], speed: 1e4 };

    /// The gripper with its base at the world's origin.
    #[must_use]
    pub fn new() -> Self {
        Self {
            base: Base::default(),
            limits: Limits {
                lower: One::new(0.053),
                upper: One::new(0.091),
                velocity: One::new(0.01),
                acceleration: One::new(0.02),
                jerk: None,
            },
        }
    }

    /// The same gripper with its base at `X_WB` in the world.
    #[must_use]
    #[allow(non_snake_case)]
    pub fn with_base(self, X_WB: Pose) -> Self {
        Self { base: Base::at(X_WB), ..self }
    }
}

impl Default for Gripper {
    fn default() -> Self {
        Self::new()
    }
}

impl Robot for Gripper {
    const KIND: &'static str = "gripper";

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
impl Kinematics<1> for Gripper {
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

impl Driven<1> for Gripper {
    fn motor_data(&self) -> &[MotorData; 1] {
        &[Self::MOTOR]
    }

    fn motor_limits(&self) -> &MotorLimits<1> {
        &Self::MOTOR_LIMITS
    }

    /// The root of `x = 0.074 - b m - c m²` on the side where x falls with m.
    fn motors(&self, q: &One) -> One {
        let [at_zero, b, c] = OPENING;
        One::new(((b * b + 4.0 * c * (at_zero - q[0])).sqrt() - b) / (2.0 * c))
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
        let [at_zero, b, c] = OPENING;
        let m = angles[0];
        let position = One::new(at_zero - (b + c * m) * m);
        let velocity = speeds * -(b + 2.0 * c * m);
        Shafts { joints: Measured { position, velocity }, loads: One::zeros() }
    }
}
