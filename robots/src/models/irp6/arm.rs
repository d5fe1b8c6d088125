//! The IRp-6: a six-joint arm whose links are driven through parallelograms and ball screws.
//!
//! ```text
//!        o---------------o=======+ F         side view at q1 = 0, theta2 = -90 deg,
//!        |  a3 (theta3)  T  d5   |           theta3 = theta4 = 0, q5 = 270 deg:
//!        |           (theta4),   | N (q6)    the tool points straight down
//!     a2 |            V (q5)     |
//!        | (theta2)              v z_F       theta2, theta3, theta4: how far a link points
//!   z_B  |                                   below the horizontal; all turn about y_B
//!    ^   |                                   (turned by q1)
//!    +-> B  shoulder
//!  x_B   |
//!        |  column (q1 about z_B)
//! ```
//!
//! **Frames.** B: the base, its origin at the shoulder where the axes of the column and of the lower link
//! meet, z_B up. F: the flange, its origin at the end of d5 (where the axis of N meets that of V), z_F along
//! the tool. W: the world; [`Irp6::with_base`] places B in it.
//!
//! **Joints.** `q1` turns the column. `q2`, `q3`, `q4` are each relative to the link before
//! (Denavit-Hartenberg): `theta2 = q2`, `theta3 = q2 + q3 + pi/2`, `theta4 = theta3 + q4`. `q5` (V) rolls the
//! wrist about d5, `q6` (N) turns the flange about z_F. As rotations
//!
//! ```text
//! R_BF = R_z(q1) R_y(theta4) R_x(q5) P R_z(q6),       P: x -> z, y -> x, z -> y
//! p_BoFo = R_z(q1) (a2 c2 + a3 c3 + d5 c4, 0, -a2 s2 - a3 s3 - d5 s4)
//! ```
//!
//! The wrist is singular where z_F is parallel to the axis of T (`sin q5 = 0`).
//!
//! **Limits.** MRROC++ wrote its joint limits for the absolute link angles and kept the figures when the
//! joints became relative. Here they bound the relative joints, as they stand in MRROC++ (q2 -130..-50,
//! q3 -25..40, q4 -90..92 deg), because demands are checked against one range per joint. The *absolute* angles are bounded
//! by the motor limits, which the drives check as well ([`Irp6::MOTOR_LOWER`]): about -125..-52 deg for
//! theta2, -25..36 for theta3, -102..99 for theta4. A pose is feasible when it keeps both;
//! [`Irp6::is_feasible`] says so. Likewise V's motor bounds q5 more narrowly than its +-10 rad: to
//! -0.71..6.71 rad on the nominal arm, -2.26..5.16 on the calibrated one, both lowered by 1.67 theta4.
//!
//! Joint speeds are at most 1.5 rad/s, and at most what a motor at its hard limit (250 rad/s) gives when the joint
//! moves alone: 1.4 rad/s for q2 and q3 (screws, at the steepest point of their stroke), 0.865 rad/s for q6. Joints
//! whose motions add up on one motor (q2, q3, q4 on T and V) can still need more of it: the drives refuse that.
//!
//! Sources: MRROC++ public facts (geometry, calibration, transmission, limits, currents). The motors'
//! electrical and mechanical constants are not public: [`MotorData`](crate::MotorData) marks them as assumed.

use core::f64::consts::PI;

use mrroc::prelude::*;
use mrroc::robot::{CoupledLimit, Limits, Measured, NoInverse, Tool};
use nalgebra::Vector3;

use super::links::{Elbow, Geometry};
use super::transmission::{Linear, Screw, Transmission};
use super::wrist::{Side, Wrist};
use crate::dynamics::Tree;
use crate::models::base::Base;
use crate::models::drives::{Driven, Encoder, GRAVITY, Gains, MotorData, MotorLimits, Shafts};
use crate::models::drives::{check_motors, check_motors_on_moves, motor_limits_in_words};
use crate::models::kinematics::{Jacobian, Kinematics};
use crate::models::shape::Outline;
use crate::models::urdf::export::exported;
use crate::models::vectors::Six;

/// An IRp-6 arm on its postument, without gripper.
#[derive(Clone, Debug, PartialEq)]
pub struct Irp6 {
    geometry: Geometry,
    transmission: Transmission,
    base: Base,
    limits: Limits<Six>,
}

impl Irp6 {
    /// A posture to begin motions in \[rad\]: the lower arm upright and the tool pointing down, to 3 mrad. The flange is 0.85 m ahead
    /// of the shoulder and 0.35 m above it. Every joint is half a radian within its limits, and the arm is far from its singularities.
    pub const READY: Six = Six::new(0.0, -1.57, 0.16, -0.16, 4.71, 0.0);

    /// Lowest motor angles \[rad\] (MRROC++).
    pub const MOTOR_LOWER: Six = Six::new(-470.0, -110.0, -80.0, -70.0, -80.0, -1000.0);
    /// Highest motor angles \[rad\] (MRROC++).
    pub const MOTOR_UPPER: Six = Six::new(450.0, 100.0, 100.0, 380.0, 490.0, 3000.0);
    /// Hard limit of every motor's speed: 0.5 rad per servo period of 2 ms [rad/s] (MRROC++).
    pub const MOTOR_SPEED: f64 = 250.0;

    pub(crate) const MOTOR_LIMITS: MotorLimits<6> = MotorLimits {
        lower: Self::MOTOR_LOWER.data.0[0],
        upper: Self::MOTOR_UPPER.data.0[0],
        speed: Self::MOTOR_SPEED,
    };

    /// Distance from the wrist singularity \[rad\] within which faults name it: joints 4 and 6 turn ten times as
    /// fast there as the tool.
    pub const NEAR_SINGULARITY: f64 = 0.1;
    /// First moments of mass that load the lower and the upper arm, after balancing [kg m] (assumed).
    pub const GRAVITY_MOMENT: [f64; 2] = [6.0, 4.0];
    /// Drives of column, lower arm, upper arm, T, V, N.
    ///
    /// The assumed figures are those of DC disc motors at 96 V, chosen so that the published gains give a sound
    /// servo loop on each axis: it crosses over at 99 to 130 rad/s with a phase margin of 45 to 56 deg and a gain
    /// margin above 6.7 (`tests/reference/servo_margins.py`), and every joint alone can reach its acceleration and
    /// speed limits within the lasting current.
    #[rustfmt::skip]
    pub const MOTORS: [MotorData; 6] = [
        MotorData { encoder: Encoder { pulses: 4000.0 }, current_limit: 15.0,
            gains: Gains { a: 0.429, b0: 6.834, b1: 6.606, feedforward: 0.35 }, resistance: 3.66,
            torque_constant: 0.20, inertia: 2.5e-3, viscous: 1e-3, coulomb: 0.08, ..MotorData::DISC },
        MotorData { encoder: Encoder { pulses: 4000.0 }, current_limit: 18.0,
            gains: Gains { a: 0.64, b0: 2.49, b1: 2.385, feedforward: 0.35 }, resistance: 2.80,
            torque_constant: 0.20, inertia: 2.2e-3, viscous: 1e-3, coulomb: 0.10, ..MotorData::DISC },
        MotorData { encoder: Encoder { pulses: 4000.0 }, current_limit: 10.0,
            gains: Gains { a: 0.333, b0: 5.693, b1: 5.427, feedforward: 0.35 }, resistance: 5.30,
            torque_constant: 0.20, inertia: 1.2e-3, viscous: 1e-3, coulomb: 0.08, ..MotorData::DISC },
        MotorData { encoder: Encoder { pulses: 4000.0 }, current_limit: 10.0,
            gains: Gains { a: 0.56, b0: 3.99, b1: 3.775, feedforward: 0.35 }, resistance: 6.50,
            torque_constant: 0.18, inertia: 9e-4, viscous: 5e-4, coulomb: 0.04, ..MotorData::DISC },
        MotorData { encoder: Encoder { pulses: 4000.0 }, current_limit: 10.0,
            gains: Gains { a: 0.39, b0: 4.31, b1: 3.945, feedforward: 0.35 }, resistance: 6.50,
            torque_constant: 0.18, inertia: 7e-4, viscous: 5e-4, coulomb: 0.04, ..MotorData::DISC },
        MotorData { encoder: Encoder { pulses: 2000.0 }, current_limit: 10.0,
            gains: Gains { a: 0.39, b0: 4.31, b1: 3.945, feedforward: 0.35 }, resistance: 6.50,
            torque_constant: 0.18, inertia: 3.5e-4, viscous: 5e-4, coulomb: 0.04, ..MotorData::DISC },
    ];

    /// The arm with its design dimensions, its base at the world's origin.
    #[must_use]
    pub fn nominal() -> Self {
        Self::new(Geometry::NOMINAL, nominal_transmission([-15.9, -5.0, -8.527, 151.31, 435.25, 791.0]))
    }

    /// The arm on the postument with its calibrated dimensions, its base at the world's origin.
    #[must_use]
    pub fn calibrated() -> Self {
        Self::new(
            Geometry { a2: 0.4596, a3: 0.6729, d5: 0.1903 },
            transmission(
                78379.4388,
                [60059.3311, -32453.0983, 211.8108],
                [-42863.8177, -53294.4762, 187.6529],
                [-7.7597, -8.7537, -7.5355, 153.1366, 309.5910, 796.0265],
                [0.0111, 0.0903, 0.0209],
            ),
        )
    }

    fn new(geometry: Geometry, transmission: Transmission) -> Self {
        let degrees = PI / 180.0;
        Self {
            geometry,
            transmission,
            base: Base::default(),
            limits: Limits {
                lower: Six::new(
                    -170.0 * degrees,
                    -130.0 * degrees,
                    -25.0 * degrees,
                    -90.0 * degrees,
                    -10.0,
                    -2.88,
                ),
                upper: Six::new(170.0 * degrees, -50.0 * degrees, 40.0 * degrees, 92.0 * degrees, 10.0, 2.93),
                velocity: Six::new(1.5, 1.4, 1.4, 1.5, 1.5, 0.865),
                acceleration: Six::repeat(7.0),
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

    /// The same arm with other lengths of its links, a2, a3, d5 \[m\], and other drives: as a calibration finds them. Each length is
    /// finite and > 0.
    #[must_use]
    pub fn with_dimensions(self, lengths: [f64; 3], transmission: Transmission) -> Self {
        let [a2, a3, d5] = lengths;
        Self { geometry: Geometry { a2, a3, d5 }, transmission, ..self }
    }

    /// The lengths of its links, a2, a3, d5 \[m\].
    #[must_use]
    pub const fn lengths(&self) -> [f64; 3] {
        let Geometry { a2, a3, d5 } = self.geometry;
        [a2, a3, d5]
    }

    /// The drives' gears and screws.
    #[must_use]
    pub fn transmission(&self) -> &Transmission {
        &self.transmission
    }

    /// Whether `q` \[rad\] keeps the joint limits and, through the transmission, the motor limits.
    #[must_use]
    pub fn is_feasible(&self, q: &Six) -> bool {
        self.is_attainable(q)
    }

    /// How far q5 is from the nearest wrist singularity \[rad\], 0 to pi/2.
    #[must_use]
    pub fn wrist_singularity_distance(q: &Six) -> f64 {
        let (sine, cosine) = q[4].sin_cos();
        sine.abs().atan2(cosine.abs())
    }

    /// Both wrist solutions for the flange at `X_WF`, first the one with `sin q5 >= 0`; every joint within pi of `near`.
    ///
    /// The shoulder stays in front and the elbow up: the motor limits exclude the other branches (they keep
    /// theta3 - theta2 between 27 and 161 deg and the flange at least 0.2 m in front of the column).
    /// [`Kinematics::solutions`] visits those as well.
    #[allow(non_snake_case)]
    pub fn all_solutions(&self, X_WF: &Pose, near: &Six) -> [Result<Six, NoInverse>; 2] {
        match Wrist::of(&(self.base.X_BW * X_WF), Side::Front, near) {
            Err(why) => [Err(why); 2],
            Ok(wrist) => [wrist, wrist.flipped()].map(|wrist| self.geometry.solve(&wrist, Elbow::Up, near)),
        }
    }
}

impl Robot for Irp6 {
    const KIND: &'static str = "irp6";

    type Joints = Six;

    fn limits(&self) -> &Limits<Six> {
        &self.limits
    }

    fn near_singularity(&self, q: &Six) -> Option<&'static str> {
        (Self::wrist_singularity_distance(q) < Self::NEAR_SINGULARITY).then_some("near the wrist singularity")
    }

    fn coupled_limits(&self) -> Vec<String> {
        motor_limits_in_words(self)
    }

    fn check_coupled(&self, from: &Six, to: &Six, duration: f64) -> Result<(), CoupledLimit> {
        check_motors(self, from, to, duration)
    }

    fn check_coupled_to_stop(
        &self,
        from: &Six,
        (to, duration): (&Six, f64),
        (stop, time): (&Six, f64),
    ) -> Result<(), CoupledLimit> {
        check_motors_on_moves(self, from, [(to, duration), (stop, time)])
    }

    fn forward(&self, q: &Six) -> Pose {
        self.base.X_WB * self.geometry.flange(q)
    }

    /// Visits the frames `X_WL` that the links carry, from base to flange: B, shoulder (turned by q1), elbow, wrist
    /// pitch T, end of d5 (turned by q5), flange. z of the first two is the column's axis; x of the next three lies
    /// along the link that follows.
    fn frames(&self, q: &Six, visit: &mut dyn FnMut(&Pose)) {
        visit(&self.base.X_WB);
        self.geometry.links(q, &mut |link| visit(&(self.base.X_WB * link)));
        visit(&self.forward(q));
    }

    fn capsules_of_links(&self, q: &Six, visit: &mut dyn FnMut([Vector3<f64>; 2], f64)) {
        Outline::capsules(self, q, &mut |capsule| visit(capsule.ends, capsule.radius));
    }

    #[allow(non_snake_case)]
    fn inverse(&self, X_WF: &Pose, near: &Six) -> Result<Six, NoInverse> {
        self.geometry.nearest(&(self.base.X_BW * X_WF), near)
    }

    fn urdf(&self, name: &str, tool: &Tool) -> Option<String> {
        exported(self, name, tool)
    }
}

/// All eight solutions: shoulder in front or behind, elbow up or down, wrist turned or not. The linkages allow the shoulder
/// in front and the elbow up alone, which is what [`Robot::inverse`] gives.
impl Kinematics<6> for Irp6 {
    fn reach(&self) -> f64 {
        self.geometry.length()
    }

    fn jacobian(&self, q: &Six) -> Jacobian<6> {
        self.geometry.jacobian(q, &self.base.X_WB.rotation)
    }

    #[allow(non_snake_case)]
    fn solutions(&self, X_WF: &Pose, near: &Six, visit: &mut dyn FnMut(&Six)) -> Result<(), NoInverse> {
        self.geometry.solutions(&(self.base.X_BW * X_WF), near, visit)
    }

    /// |det J| = |rho a2 a3 sin(theta3 - theta2) sin(q5)| \[m³\], where rho is the distance of the flange from the
    /// column axis.
    fn manipulability(&self, q: &Six) -> f64 {
        self.geometry.determinant(q)
    }
}

impl Driven<6> for Irp6 {
    fn motor_data(&self) -> &[MotorData; 6] {
        &Self::MOTORS
    }

    fn motor_limits(&self) -> &MotorLimits<6> {
        &Self::MOTOR_LIMITS
    }

    fn marks(&self) -> Six {
        self.transmission.marks()
    }

    fn tree(&self) -> Option<Tree<6>> {
        Self::bodies(&self.geometry, self.base.X_WB)
    }

    fn motors(&self, q: &Six) -> Six {
        self.transmission.motors(q)
    }

    fn shafts(&self, angles: &Six, speeds: &Six) -> Shafts<6> {
        arm_shafts(&self.transmission, angles, speeds)
    }

    fn loads(&self, angles: &Six) -> Six {
        let Transmission { lower, upper, .. } = &self.transmission;
        let [lower, upper] = [lower.lever(angles[1]), upper.lever(angles[2])];
        let [lower, upper] = weights([lower.cosine, upper.cosine], [lower.ratio, upper.ratio]);
        Six::new(0.0, lower, upper, 0.0, 0.0, 0.0)
    }
}

/// Joints and loads of the arm from its motors, through its transmission.
pub(crate) fn arm_shafts(transmission: &Transmission, angles: &Six, speeds: &Six) -> Shafts<6> {
    let lower = transmission.lower.link(angles[1]);
    let upper = transmission.upper.link(angles[2]);
    let joints = Measured {
        position: transmission.assemble(angles, &lower, &upper),
        velocity: transmission.joint_rates(speeds, &lower, &upper),
    };
    let [lower, upper] = weights([lower.cosine, upper.cosine], [lower.ratio, upper.ratio]);
    Shafts { joints, loads: Six::new(0.0, lower, upper, 0.0, 0.0, 0.0) }
}

/// Torques of the links' weight at the motors of the lower and the upper arm [N m]. Weight turns a link downwards,
/// which is positive motion, so these loads are negative.
fn weights(cosines: [f64; 2], ratios: [f64; 2]) -> [f64; 2] {
    core::array::from_fn(|i| -GRAVITY * Irp6::GRAVITY_MOMENT[i] * cosines[i] / ratios[i])
}

/// The drives with the design's screws, from the synchronisation positions.
pub(crate) fn nominal_transmission(synchro: [f64; 6]) -> Transmission {
    let lower = [60902.55, -29346.68, 220.3374];
    let upper = [-44100.0, -51240.0, 183.8348];
    transmission(77895.25, lower, upper, synchro, [0.0; 3])
}

/// The drives, from the terms of the screws, the synchronisation positions and the offsets of q1, q5, q6.
pub(crate) fn transmission(
    square: f64,
    lower: [f64; 3],
    upper: [f64; 3],
    synchro: [f64; 6],
    offset: [f64; 3],
) -> Transmission {
    let screw = |synchro, [mu, nu, reference]: [f64; 3]| Screw { synchro, square, mu, nu, reference };
    Transmission {
        column: Linear { synchro: synchro[0], gear: -158.0, offset: offset[0] },
        lower: screw(synchro[1], lower),
        upper: screw(synchro[2], upper),
        t: Linear { synchro: synchro[3], gear: -128.0, offset: 0.0 },
        v: Linear { synchro: synchro[4], gear: -76.8, offset: offset[1] },
        n: Linear { synchro: synchro[5], gear: 288.8845, offset: offset[2] },
    }
}
