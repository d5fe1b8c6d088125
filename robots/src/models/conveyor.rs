//! The conveyor: a belt, one joint without an end.
//!
//! ```text
//!      B--> x_B ------ F ------->   position x of the belt, F: a mark on it, axes as B
//!    (o========================o)
//! ```
//!
//! **Joint.** `x`, how far the belt has run \[m\]; it starts synchronised, at 0 where the program begins. **Limits.** A
//! belt has no end; the ±1000 m here only keep the numbers finite. 0.2 m/s is the fastest in MRROC++'s files; 0.05 m/s² is
//! assumed. **Inverse.** A pose off the line of F by more than [`Conveyor::OFF`] \[m or rad\] is refused.
//!
//! Sources: MRROC++ public facts (2250 rad/m, encoder, 0.2 A, speeds). The motor's constants and its gains (those of the
//! IRp-6's column) are assumed.

use mrroc::prelude::*;
use mrroc::robot::{CoupledLimit, JointKind, Limits, Load, Measured, NoInverse, Tool};
use nalgebra::{Translation3, Vector3};

use crate::dynamics::{Segment, Tree};
use crate::models::base::Base;
use crate::models::drives::{Driven, MotorData, MotorLimits, Shafts, check_motors, motor_limits_in_words};
use crate::models::kinematics::{Jacobian, Kinematics, column, position_along_x};
use crate::models::urdf::export::exported;
use crate::models::vectors::One;

/// A conveyor belt.
#[derive(Clone, Debug, PartialEq)]
pub struct Conveyor {
    base: Base,
    limits: Limits<One>,
}

impl Conveyor {
    /// Largest distance of a demanded pose from the nearest one on the belt \[m or rad\].
    pub const OFF: f64 = 1e-6;
    /// Motor angle per distance of the belt [rad/m] (MRROC++).
    pub const GEAR: f64 = 2250.0;
    /// Mass of the belt, its drums counted with it \[kg\] (assumed).
    pub const BELT: f64 = 10.0;
    /// The drive: encoder and current are facts, the rest assumed.
    pub const MOTOR: MotorData = MotorData {
        current_limit: 0.2,
        resistance: 45.7,
        torque_constant: 0.1,
        inertia: 1e-4,
        viscous: 5e-6,
        coulomb: 5e-3,
        ..MotorData::DISC
    };
    const MOTOR_LIMITS: MotorLimits<1> =
        MotorLimits { lower: [-2_251_000.0], upper: [2_251_000.0], speed: 500.0 };

    /// The conveyor with its base at the world's origin.
    #[must_use]
    pub fn new() -> Self {
        Self {
            base: Base::default(),
            limits: Limits {
                lower: One::new(-1000.0),
                upper: One::new(1000.0),
                velocity: One::new(0.2),
                acceleration: One::new(0.05),
                jerk: None,
            },
        }
    }

    /// The same conveyor with its base at `X_WB` in the world.
    #[must_use]
    #[allow(non_snake_case)]
    pub fn with_base(self, X_WB: Pose) -> Self {
        Self { base: Base::at(X_WB), ..self }
    }
}

impl Default for Conveyor {
    fn default() -> Self {
        Self::new()
    }
}

impl Robot for Conveyor {
    const KIND: &'static str = "conveyor";

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
        self.base.X_WB * Translation3::new(q[0], 0.0, 0.0)
    }

    /// Visits the frames `X_WL`: B, the mark F.
    fn frames(&self, q: &One, visit: &mut dyn FnMut(&Pose)) {
        visit(&self.base.X_WB);
        visit(&self.forward(q));
    }

    #[allow(non_snake_case)]
    fn inverse(&self, X_WF: &Pose, _near: &One) -> Result<One, NoInverse> {
        position_along_x(&(self.base.X_BW * X_WF), Self::OFF).map(One::new)
    }

    fn urdf(&self, name: &str, tool: &Tool) -> Option<String> {
        exported(self, name, tool)
    }
}

/// One solution; no posture is singular.
impl Kinematics<1> for Conveyor {
    fn reach(&self) -> f64 {
        1.0
    }

    fn jacobian(&self, _q: &One) -> Jacobian<1> {
        column(&(self.base.X_WB.rotation * Vector3::x()), &Vector3::zeros())
    }

    #[allow(non_snake_case)]
    fn solutions(&self, X_WF: &Pose, near: &One, visit: &mut dyn FnMut(&One)) -> Result<(), NoInverse> {
        visit(&self.inverse(X_WF, near)?);
        Ok(())
    }
}

impl Driven<1> for Conveyor {
    fn motor_data(&self) -> &[MotorData; 1] {
        &[Self::MOTOR]
    }

    fn motor_limits(&self) -> &MotorLimits<1> {
        &Self::MOTOR_LIMITS
    }

    fn motors(&self, q: &One) -> One {
        q * Self::GEAR
    }

    /// Two strands, of which one returns: on a slope their weights balance.
    fn tree(&self) -> Option<Tree<1>> {
        let half = Load::point(0.5 * Self::BELT, Vector3::zeros());
        let strand =
            |name, parent| Segment::sliding(name, parent, 0, Vector3::zeros(), Vector3::x()).carrying(half);
        let strands = vec![strand("returning_strand", None).following(-1.0), strand("belt", None)];
        Tree::new(self.base.X_WB, strands, Pose::identity()).ok()
    }

    fn shafts(&self, angles: &One, speeds: &One) -> Shafts<1> {
        let joints = Measured { position: angles / Self::GEAR, velocity: speeds / Self::GEAR };
        Shafts { joints, loads: One::zeros() }
    }
}
