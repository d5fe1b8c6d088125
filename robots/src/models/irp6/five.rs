//! The IRp-6 with five joints, the older wrist: the tool lies along the wrist link and cannot be tilted out of the arm's
//! vertical plane.
//!
//! ```text
//!        o---------------o====+=> z_F     side view at q1 = 0, theta2 = -90 deg, theta3 = theta4 = 0
//!        |  a3 (theta3)  T d6 F
//!     a2 |          (theta4)  V (q5) turns the flange about z_F
//!        | (theta2)                theta2, theta3, theta4: how far a link points below the horizontal
//!        o shoulder
//!        |
//!     d1 |  column (q1 about z_B)      at q5 = 0: x_F upwards, y_F to the right (-y of the arm's plane)
//!   z_B  |
//!    +-> B  floor
//! ```
//!
//! **Frames.** B: on the floor under the shoulder, z_B up. F: origin at the end of d6, z_F along the tool. **Joints.**
//! As for [`Irp6`]: relative (`theta2 = q2`, `theta3 = q2 + q3 + pi/2`, `theta4 = theta3 + q4`); MRROC++ kept absolute
//! angles here when it made all others relative.
//!
//! ```text
//! p_BoFo = R_z(q1) (a2 c2 + a3 c3 + d6 c4, 0, d1 - a2 s2 - a3 s3 - d6 s4),    z_F = R_z(q1) (c4, 0, -s4)
//! ```
//!
//! **The sixth coordinate.** Five joints attain the tool's point, the direction of its axis within the arm's vertical
//! plane, and the turn about it. That plane holds the column and the tool's point, so z_F must not lean out of it:
//! [`Robot::inverse`] refuses a pose that leans by more than [`Irp6FiveDof::LEAN`].
//! [`Irp6FiveDof::upright`] gives the nearest pose that the arm can take.
//!
//! **Limits** of joints and motors as for [`Irp6`], q5 ±10 rad. Sources: MRROC++ public
//! facts.

use core::f64::consts::{FRAC_1_SQRT_2, FRAC_PI_2};

use mrroc::prelude::*;
use mrroc::robot::{CoupledLimit, Limits, Measured, NoInverse, Tool};
use nalgebra::{Quaternion, Rotation3, Translation3, Unit, UnitQuaternion, Vector3};

use super::arm::{Irp6, arm_shafts, nominal_transmission};
use super::links::{Elbow, Geometry, two_links};
use super::transmission::Transmission;
use crate::dynamics::Tree;
use crate::models::base::Base;
use crate::models::drives::{Driven, MotorData, MotorLimits, Shafts, check_motors, motor_limits_in_words};
use crate::models::kinematics::{Jacobian, Kinematics, closest, doubled};
use crate::models::shape::Outline;
use crate::models::sines::sin_cos;
use crate::models::urdf::export::exported;
use crate::models::vectors::{Five, Six};

/// Distance of the tool's point from the column axis below which q1 is undetermined \[m\].
const SHOULDER_SINGULAR: f64 = 1e-9;

/// An IRp-6 arm with five joints.
#[derive(Clone, Debug, PartialEq)]
pub struct Irp6FiveDof {
    geometry: Geometry,
    transmission: Transmission,
    base: Base,
    limits: Limits<Five>,
}

impl Irp6FiveDof {
    /// Height of the shoulder above the floor \[m\] (MRROC++).
    pub const D1: f64 = 0.7;
    /// Largest angle by which a demanded tool axis may lean out of the arm's plane \[rad\].
    pub const LEAN: f64 = 1e-6;

    pub(crate) const MOTOR_LIMITS: MotorLimits<5> = MotorLimits {
        lower: [-470.0, -110.0, -80.0, -70.0, -80.0],
        upper: [450.0, 100.0, 100.0, 380.0, 490.0],
        speed: Irp6::MOTOR_SPEED,
    };

    /// Drives of column, lower arm, upper arm, T, V: those of the six-joint arm.
    pub const MOTORS: [MotorData; 5] =
        [Irp6::MOTORS[0], Irp6::MOTORS[1], Irp6::MOTORS[2], Irp6::MOTORS[3], Irp6::MOTORS[4]];

    /// The arm with its design dimensions, its base at the world's origin.
    #[must_use]
    pub fn nominal() -> Self {
        let arm = *Irp6::nominal().limits();
        let five = first_five;
        Self {
            geometry: Geometry { d5: 0.095, ..Geometry::NOMINAL },
            transmission: nominal_transmission([-15.9, -5.0, -8.527, 151.31, 314.665, 0.0]),
            base: Base::default(),
            limits: Limits {
                lower: five(&arm.lower),
                upper: five(&arm.upper),
                velocity: five(&arm.velocity),
                acceleration: five(&arm.acceleration),
                jerk: None,
            },
        }
    }

    /// The same arm with its base at `X_WB` in the world.
    #[must_use]
    #[allow(non_snake_case)]
    pub fn with_base(self, X_WB: Pose) -> Self {
        Self { base: Base::at(X_WB), ..self }
    }

    /// The pose nearest to `X_WF` that five joints can attain: the same point, the tool axis turned the least into the
    /// arm's vertical plane.
    ///
    /// # Errors
    /// [`NoInverse::Singular`] when the axis is perpendicular to the plane, or the point lies on the column's axis.
    #[allow(non_snake_case)]
    pub fn upright(&self, X_WF: &Pose) -> Result<Pose, NoInverse> {
        let X_BF = self.base.X_BW * X_WF;
        let p = X_BF.translation.vector;
        let axis = X_BF.rotation * Vector3::z();
        let aside = Unit::try_new(Vector3::new(-p.y, p.x, 0.0), SHOULDER_SINGULAR)
            .ok_or(NoInverse::Singular { name: "shoulder" })?;
        let within = axis - aside.into_inner() * axis.dot(&aside);
        let turn = Rotation3::rotation_between(&axis, &within)
            .filter(|_| within.norm() > 1e-9)
            .ok_or(NoInverse::Singular { name: "tool across the arm's plane" })?;
        let rotation = UnitQuaternion::from_rotation_matrix(&turn) * X_BF.rotation;
        Ok(self.base.X_WB * Pose::from_parts(X_BF.translation, rotation))
    }

    /// The arm's gears and screws; there is no motor N.
    #[must_use]
    pub fn transmission(&self) -> &Transmission {
        &self.transmission
    }

    /// One solution: the tool's point in the vertical plane of the arm, which is turned by theta1.
    #[inline]
    #[allow(non_snake_case)]
    fn solve(&self, X_BF: &Pose, back: bool, elbow: Elbow, near: &Five) -> Result<Five, NoInverse> {
        let Geometry { a2, a3, d5: d6 } = self.geometry;
        let p = X_BF.translation.vector;
        let distance = p.x.hypot(p.y);
        if distance.is_nan() || distance < SHOULDER_SINGULAR {
            return Err(NoInverse::Singular { name: "shoulder" });
        }
        let rho = if back { -distance } else { distance };
        let (s1, c1) = (p.y / rho, p.x / rho);
        let rotation = X_BF.rotation.to_rotation_matrix();
        let r = rotation.matrix();
        let lean = c1 * r[(1, 2)] - s1 * r[(0, 2)];
        if lean.is_nan() || lean.abs() > Self::LEAN {
            return Err(NoInverse::NotAttainable {
                what: "lean out of the arm's plane",
                actual: lean.abs().min(1.0).asin(),
                tolerance: Self::LEAN,
                unit: "rad",
            });
        }
        let s4 = -r[(2, 2)];
        let c4 = c1 * r[(0, 2)] + s1 * r[(1, 2)];
        let theta4 = s4.atan2(c4);
        let size = s4.hypot(c4);
        let (s4, c4) = (s4 / size, c4 / size);
        let (theta2, theta3) = two_links(a2, a3, rho - d6 * c4, Self::D1 - p.z - d6 * s4, elbow)?;
        // x_F = c5 (s4 c1, s4 s1, c4) + s5 (s1, -c1, 0).
        let x = r.column(0);
        let theta5 = (s1 * x[0] - c1 * x[1]).atan2(s4 * (c1 * x[0] + s1 * x[1]) + c4 * x[2]);
        let theta1 = if back { (-p.y).atan2(-p.x) } else { p.y.atan2(p.x) };
        Ok(Five::new(
            closest(theta1, near[0]),
            closest(theta2, near[1]),
            closest(theta3 - theta2 - FRAC_PI_2, near[2]),
            closest(theta4 - theta3, near[3]),
            closest(theta5, near[4]),
        ))
    }
}

/// The joints with a sixth at 0.
fn with_sixth(q: &Five) -> Six {
    Six::new(q[0], q[1], q[2], q[3], q[4], 0.0)
}

/// All joints but the sixth.
fn first_five(six: &Six) -> Five {
    Five::from_fn(|i, _| six[i])
}

impl Robot for Irp6FiveDof {
    const KIND: &'static str = "irp6-5dof";

    type Joints = Five;

    fn limits(&self) -> &Limits<Five> {
        &self.limits
    }

    fn coupled_limits(&self) -> Vec<String> {
        motor_limits_in_words(self)
    }

    fn check_coupled(&self, from: &Five, to: &Five, duration: f64) -> Result<(), CoupledLimit> {
        check_motors(self, from, to, duration)
    }

    fn forward(&self, q: &Five) -> Pose {
        let Geometry { a2, a3, d5: d6 } = self.geometry;
        let theta3 = q[1] + q[2] + FRAC_PI_2;
        // The sixth angle is not needed: an odd number of angles costs as much as the next even one.
        let [(s2, c2), (s3, c3), h1, h4, h5, _] =
            sin_cos([q[1], theta3, 0.5 * q[0], 0.5 * (theta3 + q[3]), 0.5 * q[4], 0.0]);
        let ((s1, c1), (s4, c4)) = (doubled(h1), doubled(h4));
        let rho = a2 * c2 + a3 * c3 + d6 * c4;
        let position = Translation3::new(c1 * rho, s1 * rho, Self::D1 - a2 * s2 - a3 * s3 - d6 * s4);
        // R_z(q1) R_y(theta4) (x -> z, y -> -y, z -> x) R_z(q5); the middle one is half a turn about x + z.
        let arm = Quaternion::new(h1.1 * h4.1, -h1.0 * h4.0, h1.1 * h4.0, h1.0 * h4.1);
        let sine = FRAC_1_SQRT_2 * h5.0;
        let cosine = FRAC_1_SQRT_2 * h5.1;
        let roll = Quaternion::new(-sine, cosine, -sine, cosine);
        self.base.X_WB * Pose::from_parts(position, UnitQuaternion::new_unchecked(arm * roll))
    }

    /// Visits the frames `X_WL` that the links carry, from base to flange: B, shoulder, elbow, T, end of d6, flange.
    fn frames(&self, q: &Five, visit: &mut dyn FnMut(&Pose)) {
        visit(&self.base.X_WB);
        let shoulder = self.base.X_WB * Translation3::new(0.0, 0.0, Self::D1);
        self.geometry.links(&with_sixth(q), &mut |link| visit(&(shoulder * link)));
        visit(&self.forward(q));
    }

    fn capsules_of_links(&self, q: &Five, visit: &mut dyn FnMut([Vector3<f64>; 2], f64)) {
        Outline::capsules(self, q, &mut |capsule| visit(capsule.ends, capsule.radius));
    }

    /// Shoulder in front and elbow up, as the linkages force it.
    #[allow(non_snake_case)]
    fn inverse(&self, X_WF: &Pose, near: &Five) -> Result<Five, NoInverse> {
        self.solve(&(self.base.X_BW * X_WF), false, Elbow::Up, near)
    }

    fn urdf(&self, name: &str, tool: &Tool) -> Option<String> {
        exported(self, name, tool)
    }
}

/// All four solutions: shoulder in front or behind, elbow up or down. The linkages allow the first alone, which is what
/// [`Robot::inverse`] gives.
impl Kinematics<5> for Irp6FiveDof {
    fn reach(&self) -> f64 {
        self.geometry.length()
    }

    fn jacobian(&self, q: &Five) -> Jacobian<5> {
        let arm = self.geometry.jacobian(&with_sixth(q), &self.base.X_WB.rotation);
        arm.fixed_columns::<5>(0).into_owned()
    }

    #[allow(non_snake_case)]
    fn solutions(&self, X_WF: &Pose, near: &Five, visit: &mut dyn FnMut(&Five)) -> Result<(), NoInverse> {
        let X_BF = self.base.X_BW * X_WF;
        let mut refused = None;
        let mut any = false;
        for back in [false, true] {
            for elbow in [Elbow::Up, Elbow::Down] {
                match self.solve(&X_BF, back, elbow, near) {
                    Ok(q) => {
                        any = true;
                        visit(&q);
                    }
                    Err(why) => refused = refused.or(Some(why)),
                }
            }
        }
        refused.filter(|_| !any).map_or(Ok(()), Err)
    }
}

impl Driven<5> for Irp6FiveDof {
    fn motor_data(&self) -> &[MotorData; 5] {
        &Self::MOTORS
    }

    fn motor_limits(&self) -> &MotorLimits<5> {
        &Self::MOTOR_LIMITS
    }

    fn marks(&self) -> Five {
        first_five(&self.transmission.marks())
    }

    fn tree(&self) -> Option<Tree<5>> {
        Self::bodies(&self.geometry, self.base.X_WB)
    }

    fn motors(&self, q: &Five) -> Five {
        first_five(&self.transmission.motors(&with_sixth(q)))
    }

    fn shafts(&self, angles: &Five, speeds: &Five) -> Shafts<5> {
        let arm = arm_shafts(&self.transmission, &with_sixth(angles), &with_sixth(speeds));
        Shafts {
            joints: Measured {
                position: first_five(&arm.joints.position),
                velocity: first_five(&arm.joints.velocity),
            },
            loads: first_five(&arm.loads),
        }
    }
}
