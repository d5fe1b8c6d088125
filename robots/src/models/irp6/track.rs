//! The IRp-6 on its track: the six-joint arm on a carriage, seven joints in all.
//!
//! ```text
//!        top view, q1 = 0                        y_B = direction of the track
//!
//!   y_B ^   ======+=========+==========  track      X_BF = translation by d along y_B,
//!       |         |  column |                              then the arm's own X_BF
//!       |         |    o----|------> arm (x_B)
//!       B--> x_B  +---------+        d = q[0]: carriage, from B
//! ```
//!
//! **Frames.** B: where the shoulder stands at `d = 0`, y_B along the track, z_B up. F and the arm's joints are those of
//! [`Irp6`]. **Joints.** `d` \[m\], then `q1..q6` \[rad\].
//!
//! **Redundancy.** Seven joints for six coordinates. [`Robot::inverse`] keeps the track where `near` has it; when the arm
//! cannot reach from there, it moves the track as little as lets it reach, found to 1e-10 m by steps of
//! [`Irp6Track::SEARCH_STEP`] and bisection: a stretch of the track that is shorter than a step may be missed. The arm
//! then is stretched: a path that needs the track to move should say so, by [`Robot::inverse_at`], which takes the
//! track's position as a parameter of the pose.
//!
//! **Limits.** Track -0.125..1.21 m, 0.159 m/s (250 rad/s at the motor), its acceleration 0.5 m/s² assumed; the arm's as
//! for [`Irp6`]. The motor's own limit ends the track at 1.2096 m.
//!
//! Sources: MRROC++ public facts (geometry, both calibrations, transmission, limits). Its model with a track chose wrong
//! joint indices since 2010; here the arm is the same code as without the track.

use mrroc::prelude::*;
use mrroc::robot::{CoupledLimit, JointKind, Limits, Measured, NoInverse, Tool};
use nalgebra::{Matrix3, Translation3, UnitQuaternion, Vector3};

use super::arm::{Irp6, arm_shafts, nominal_transmission, transmission};
use super::links::Geometry;
use super::transmission::{Linear, Transmission};
use crate::dynamics::Tree;
use crate::models::base::Base;
use crate::models::drives::{
    Driven, Gains, MotorData, MotorLimits, Shafts, check_motors, motor_limits_in_words,
};
use crate::models::kinematics::{Jacobian, Kinematics, column};
use crate::models::shape::Outline;
use crate::models::urdf::export::exported;
use crate::models::vectors::{Seven, Six};

/// An IRp-6 arm on its track, without gripper.
#[derive(Clone, Debug, PartialEq)]
pub struct Irp6Track {
    geometry: Geometry,
    track: Linear,
    transmission: Transmission,
    base: Base,
    limits: Limits<Seven>,
}

impl Irp6Track {
    /// Motor angle per distance of the carriage [rad/m] (MRROC++: ball screw of 8 mm lead, belt 2).
    pub const TRACK_GEAR: f64 = 500.0 * core::f64::consts::PI;
    /// Drive of the track, before those of the arm ([`Irp6::MOTORS`]): 25 A and its gains from MRROC++, the rest assumed.
    pub const TRACK_MOTOR: MotorData = MotorData {
        gains: Gains { a: 0.333, b0: 6.2, b1: 5.933, feedforward: 0.35 },
        current_limit: 25.0,
        resistance: 4.16,
        inertia: 2.2e-3,
        coulomb: 0.10,
        ..MotorData::DISC
    };
    /// Drives of track, column, lower arm, upper arm, T, V, N.
    pub const MOTORS: [MotorData; 7] = [
        Self::TRACK_MOTOR,
        Irp6::MOTORS[0],
        Irp6::MOTORS[1],
        Irp6::MOTORS[2],
        Irp6::MOTORS[3],
        Irp6::MOTORS[4],
        Irp6::MOTORS[5],
    ];

    /// Steps in which the track is searched for a place to reach from \[m\].
    pub const SEARCH_STEP: f64 = 0.01;

    pub(crate) const MOTOR_LIMITS: MotorLimits<7> = MotorLimits {
        lower: [-200.0, -470.0, -110.0, -80.0, -70.0, -80.0, -1000.0],
        upper: [1900.0, 450.0, 100.0, 100.0, 380.0, 490.0, 3000.0],
        speed: Irp6::MOTOR_SPEED,
    };

    /// The arm with its design dimensions, the track's B at the world's origin.
    #[must_use]
    pub fn nominal() -> Self {
        Self::new(
            Geometry::NOMINAL,
            0.0,
            nominal_transmission([-10.819, -4.012, -6.219, 158.997, 479.5, 769.7]),
        )
    }

    /// The arm with its calibrated dimensions, the track's B at the world's origin.
    #[must_use]
    pub fn calibrated() -> Self {
        Self::new(
            Geometry { a2: 0.4647, a3: 0.6748, d5: 0.1967 },
            -0.0117,
            transmission(
                79744.63,
                [65788.63, -22524.88, 223.9765],
                [-44612.77, -52925.22, 189.1123],
                [-7.185, -23.7333, -4.0065, 153.6764, 356.0929, 791.4409],
                [0.004989, 0.000898, 0.005605],
            ),
        )
    }

    fn new(geometry: Geometry, synchro: f64, transmission: Transmission) -> Self {
        let arm = *Irp6::nominal().limits();
        let with = |track, arm: &Six| Seven::from_fn(|i, _| if i == 0 { track } else { arm[i - 1] });
        Self {
            geometry,
            track: Linear { synchro, gear: Self::TRACK_GEAR, offset: 0.0 },
            transmission,
            base: Base::default(),
            limits: Limits {
                lower: with(-0.125, &arm.lower),
                upper: with(1.21, &arm.upper),
                velocity: with(0.159, &arm.velocity),
                acceleration: with(0.5, &arm.acceleration),
                jerk: None,
            },
        }
    }

    /// Where the postument arm's B stands in this robot's B, as MRROC++ calibrated the pair: 2.1063 m along the track.
    /// The published matrix is a rotation to 2e-7; here it is the nearest one.
    #[must_use]
    pub fn postument() -> Pose {
        #[rustfmt::skip]
        let rotation = Matrix3::new(
            0.999_382_684_525_334, 0.032_121_491_696_551, -0.014_228_380_312_960,
            -0.032_112_349_151_151, 0.999_483_874_031_384, 0.000_884_637_222_621,
            0.014_249_452_723_906, -0.000_427_184_516_840, 0.999_898_380_141_931,
        );
        let position =
            Translation3::new(-0.072_793_938_982_293, 2.106_338_769_845_522, -0.030_202_915_816_185);
        Pose::from_parts(position, UnitQuaternion::from_matrix(&rotation))
    }

    /// The same robot with its track's B at `X_WB` in the world.
    #[must_use]
    #[allow(non_snake_case)]
    pub fn with_base(self, X_WB: Pose) -> Self {
        Self { base: Base::at(X_WB), ..self }
    }

    /// The arm's gears and screws.
    #[must_use]
    pub fn transmission(&self) -> &Transmission {
        &self.transmission
    }

    /// The track's gear: screw and belt.
    #[must_use]
    pub fn track(&self) -> &Linear {
        &self.track
    }

    #[inline]
    #[allow(non_snake_case)]
    fn arm_at(&self, X_BF: &Pose, track: f64, near: &Seven) -> Result<Six, NoInverse> {
        self.geometry.nearest(&shifted(X_BF, -track), &arm_of(near))
    }

    /// The position of the track nearest to `near`'s from which the arm reaches `X_BF` \[m\]; `None` if there is none within
    /// its limits.
    #[allow(non_snake_case)]
    fn least_moved(&self, X_BF: &Pose, near: &Seven) -> Option<f64> {
        let from = near[0];
        let reaches = |track: f64| self.arm_at(X_BF, track, near).is_ok();
        let lower = self.limits.lower[0];
        let upper = self.limits.upper[0];
        let steps = ((upper - from).max(from - lower) / Self::SEARCH_STEP).ceil();
        if steps.is_nan() {
            return None;
        }
        let mut found = None;
        for k in 1..=steps.min(1e6) as u32 {
            let distance = f64::from(k) * Self::SEARCH_STEP;
            let ends = [(from - distance).max(lower), (from + distance).min(upper)];
            found = ends.into_iter().find(|end| reaches(*end));
            if found.is_some() {
                break;
            }
        }
        let mut inside = found?;
        let mut outside = inside + (from - inside).clamp(-Self::SEARCH_STEP, Self::SEARCH_STEP);
        while (inside - outside).abs() > 1e-10 {
            let middle = 0.5 * (inside + outside);
            if reaches(middle) {
                inside = middle;
            } else {
                outside = middle;
            }
        }
        Some(inside)
    }
}

/// The arm's joints.
fn arm_of(q: &Seven) -> Six {
    Six::new(q[1], q[2], q[3], q[4], q[5], q[6])
}

/// The track's position before the arm's joints.
fn joined(track: f64, arm: &Six) -> Seven {
    Seven::from([track, arm[0], arm[1], arm[2], arm[3], arm[4], arm[5]])
}

/// A pose moved by `shift` along the track \[m\].
#[allow(non_snake_case)]
fn shifted(X_BF: &Pose, shift: f64) -> Pose {
    let p = X_BF.translation.vector;
    Pose::from_parts(Translation3::new(p.x, p.y + shift, p.z), X_BF.rotation)
}

impl Robot for Irp6Track {
    const KIND: &'static str = "irp6-track";

    type Joints = Seven;

    fn joint(&self, i: usize) -> JointKind {
        if i == 0 { JointKind::Prismatic } else { JointKind::Revolute }
    }

    fn limits(&self) -> &Limits<Seven> {
        &self.limits
    }

    fn near_singularity(&self, q: &Seven) -> Option<&'static str> {
        (Irp6::wrist_singularity_distance(&arm_of(q)) < Irp6::NEAR_SINGULARITY)
            .then_some("near the wrist singularity")
    }

    fn coupled_limits(&self) -> Vec<String> {
        motor_limits_in_words(self)
    }

    fn check_coupled(&self, from: &Seven, to: &Seven, duration: f64) -> Result<(), CoupledLimit> {
        check_motors(self, from, to, duration)
    }

    fn forward(&self, q: &Seven) -> Pose {
        self.base.X_WB * shifted(&self.geometry.flange(&arm_of(q)), q[0])
    }

    /// Visits the frames `X_WL` that the links carry, from base to flange: B, carriage, then the arm's as
    /// [`Irp6::frames`] lists them from the shoulder on.
    fn frames(&self, q: &Seven, visit: &mut dyn FnMut(&Pose)) {
        visit(&self.base.X_WB);
        let carriage = self.base.X_WB * Translation3::new(0.0, q[0], 0.0);
        visit(&carriage);
        self.geometry.links(&arm_of(q), &mut |link| visit(&(carriage * link)));
        visit(&self.forward(q));
    }

    fn capsules_of_links(&self, q: &Seven, visit: &mut dyn FnMut([Vector3<f64>; 2], f64)) {
        Outline::capsules(self, q, &mut |capsule| visit(capsule.ends, capsule.radius));
    }

    #[allow(non_snake_case)]
    fn inverse(&self, X_WF: &Pose, near: &Seven) -> Result<Seven, NoInverse> {
        let X_BF = self.base.X_BW * X_WF;
        match self.arm_at(&X_BF, near[0], near) {
            Ok(arm) => Ok(joined(near[0], &arm)),
            Err(why) => {
                let track = self.least_moved(&X_BF, near).ok_or(why)?;
                self.arm_at(&X_BF, track, near).map(|arm| joined(track, &arm))
            }
        }
    }

    /// `redundancy`: the carriage's position d \[m\]; the arm's branch as for [`Irp6`].
    ///
    /// # Errors
    /// As [`Irp6`]: nothing is moved to make the pose reachable.
    #[allow(non_snake_case)]
    fn inverse_at(&self, X_WF: &Pose, redundancy: f64, near: &Seven) -> Result<Seven, NoInverse> {
        self.arm_at(&(self.base.X_BW * X_WF), redundancy, near).map(|arm| joined(redundancy, &arm))
    }

    fn urdf(&self, name: &str, tool: &Tool) -> Option<String> {
        exported(self, name, tool)
    }
}

/// The solutions of the arm, eight as for [`Irp6`], with the track where `near` has it, or, when the arm does not reach
/// from there, with the track moved as little as lets it reach.
impl Kinematics<7> for Irp6Track {
    fn reach(&self) -> f64 {
        self.geometry.length()
    }

    fn jacobian(&self, q: &Seven) -> Jacobian<7> {
        let arm = self.geometry.jacobian(&arm_of(q), &self.base.X_WB.rotation);
        let mut jacobian = Jacobian::<7>::zeros();
        jacobian.set_column(0, &column(&(self.base.X_WB.rotation * Vector3::y()), &Vector3::zeros()));
        jacobian.fixed_columns_mut::<6>(1).copy_from(&arm);
        jacobian
    }

    #[allow(non_snake_case)]
    fn solutions(&self, X_WF: &Pose, near: &Seven, visit: &mut dyn FnMut(&Seven)) -> Result<(), NoInverse> {
        let X_BF = self.base.X_BW * X_WF;
        let at = |track: f64, visit: &mut dyn FnMut(&Seven)| {
            let mut visit_arm = |arm: &Six| visit(&joined(track, arm));
            self.geometry.solutions(&shifted(&X_BF, -track), &arm_of(near), &mut visit_arm)
        };
        match at(near[0], visit) {
            Ok(()) => Ok(()),
            Err(why) => at(self.least_moved(&X_BF, near).ok_or(why)?, visit),
        }
    }
}

impl Driven<7> for Irp6Track {
    fn motor_data(&self) -> &[MotorData; 7] {
        &Self::MOTORS
    }

    fn motor_limits(&self) -> &MotorLimits<7> {
        &Self::MOTOR_LIMITS
    }

    fn marks(&self) -> Seven {
        joined(self.track.synchro, &self.transmission.marks())
    }

    fn tree(&self) -> Option<Tree<7>> {
        Self::bodies(&self.geometry, self.base.X_WB)
    }

    fn motors(&self, q: &Seven) -> Seven {
        joined(self.track.motor(q[0]), &self.transmission.motors(&arm_of(q)))
    }

    fn shafts(&self, angles: &Seven, speeds: &Seven) -> Shafts<7> {
        let arm = arm_shafts(&self.transmission, &arm_of(angles), &arm_of(speeds));
        Shafts {
            joints: Measured {
                position: joined(self.track.joint(angles[0]), &arm.joints.position),
                velocity: joined(speeds[0] / self.track.gear, &arm.joints.velocity),
            },
            loads: joined(0.0, &arm.loads),
        }
    }
}
