//! RNT: a serial-parallel arm, rigid enough to mill and engrave. **A stand-in**: no geometry of the prototype is public.
//! Every dimension, limit and drive here is an assumption, chosen to be plausible beside the IRp-6.
//!
//! ```text
//!                    E ___ a3 ____________ C   wrist centre (q4 about the forearm, q5, q6), then d6 along z_F to F
//!                  //|    (theta3)
//!          rod   //  |  T: tail of the forearm, 0.2 m behind E
//!        _____T-'    | a2 (theta2)
//!       /            |
//!      R---- 0.2 ----O  shoulder: upper arm and rocker turn about one axis
//!       \            |\
//!    q3  \           | \ 0.25 along a2        q2, q3: lengths of the two linear actuators
//!  (A3-R) \          |  \  q2 (A2 to the upper arm)
//!          A3        |   A2
//!          (0.55 m, 250 deg)  (0.40 m, -20 deg)      both on the column (q1 about z_B)
//! ```
//!
//! **Frames.** B: on the floor in the column's axis, z_B up; the shoulder O stands `A1` in front of it at height `D1`. F:
//! the flange, z_F along the tool. **Joints**: `q1` column \[rad\]; `q2`, `q3` lengths of the actuators \[m\]; `q4`, `q5`,
//! `q6` wrist \[rad\], `R_BF = R_z(q1) R_y(pi/2 - theta3) R_z(q4) R_y(q5) R_z(q6)`; theta2, theta3: elevations of the upper
//! arm and the forearm above the horizontal.
//!
//! **Closed linkages.** Nothing here treats the arm as an open chain: the joints are the actuators, and every call solves
//! the three loops in the arm's plane, by the law of cosines and by intersecting circles:
//!
//! ```text
//! |A2 - 0.25 e(theta2)| = q2,   |A3 - 0.2 e(rho)| = q3,   |T - R| = 0.52,  T = a2 e(theta2) - 0.2 e(theta3),  R = 0.2 e(rho)
//! ```
//!
//! The rod is longer than the upper arm: the four-bar is no parallelogram, so the forearm turns when the upper arm alone is
//! driven. Of each loop's two assemblies the drawn one is built; the other lies beyond a dead centre, from which
//! [`Rnt::TRANSMISSION`] keeps away: a motion nearer to one is refused as a limit that joints share. The wrist is singular at
//! `q5 = 0` (forearm's and flange's axes in line).

mod export;
mod linkage;
mod masses;
mod outline;

use core::f64::consts::PI;

use mrroc::fault::Excess;
use mrroc::prelude::*;
use mrroc::robot::{CoupledLimit, JointKind, Limits, Measured, NoInverse, Tool};
use nalgebra::{Quaternion, Translation3, UnitQuaternion, Vector2, Vector3};

use crate::dynamics::Dynamics;
use crate::models::base::Base;
use crate::models::drives::{
    Driven, GRAVITY, MotorData, MotorLimits, Shafts, check_motors, motor_limits_in_words,
};
use crate::models::irp6::Irp6;
use crate::models::kinematics::{Jacobian, Kinematics, closest, column, doubled};
use crate::models::shape::Outline;
use crate::models::sines::sin_cos;
use crate::models::vectors::Six;
use linkage::{Linkage, ROCKER, TAIL, left};

/// Shoulder in front of the column's axis \[m\].
const A1: f64 = 0.12;
/// Shoulder above the floor \[m\].
const D1: f64 = 0.75;
/// Upper arm \[m\].
const A2: f64 = 0.50;
/// Forearm, elbow to wrist centre \[m\].
const A3: f64 = 0.60;
/// Wrist centre to flange \[m\].
const D6: f64 = 0.12;
/// Distance of the wrist centre from the column axis below which q1 is undetermined \[m\].
const SHOULDER_SINGULAR: f64 = 1e-9;
/// Sine of q5 below which the wrist counts as singular; the pose then errs by no more than this \[rad\].
const WRIST_SINGULAR: f64 = 1e-10;

/// The stand-in for RNT, without tool.
#[derive(Clone, Debug, PartialEq)]
pub struct Rnt {
    base: Base,
    limits: Limits<Six>,
}

/// The wrist's angles that the pose gives once the forearm is known.
struct Wrist {
    q4: f64,
    q5: f64,
    q6: f64,
}

impl Rnt {
    /// Least sine of the angle at which a rod or an actuator drives its link (assumed): 15 deg off the dead centre.
    pub const TRANSMISSION: f64 = 0.258_819_045_102_520_8;

    /// Motor angle per joint angle [rad/rad], or per length of an actuator [rad/m]: a ball screw of 5 mm lead.
    pub const GEARS: [f64; 6] = [120.0, 400.0 * PI, 400.0 * PI, 100.0, 100.0, 100.0];
    /// First moments of mass that load upper arm and forearm, after balancing [kg m].
    pub const GRAVITY_MOMENT: [f64; 2] = [8.0, 5.0];
    /// The drives of the IRp-6's column, upper arm (twice) and T (three times).
    pub const MOTORS: [MotorData; 6] = [
        Irp6::MOTORS[0],
        Irp6::MOTORS[2],
        Irp6::MOTORS[2],
        Irp6::MOTORS[3],
        Irp6::MOTORS[3],
        Irp6::MOTORS[3],
    ];
    const MOTOR_LIMITS: MotorLimits<6> = MotorLimits {
        lower: [-350.0, 435.0, 485.0, -315.0, -205.0, -625.0],
        upper: [350.0, 810.0, 905.0, 315.0, 205.0, 625.0],
        speed: 260.0,
    };

    /// The arm with its base at the world's origin.
    #[must_use]
    pub fn new() -> Self {
        Self {
            base: Base::default(),
            limits: Limits {
                lower: Six::new(-2.9, 0.35, 0.39, -3.1, -2.0, -6.2),
                upper: Six::new(2.9, 0.64, 0.715, 3.1, 2.0, 6.2),
                velocity: Six::new(1.5, 0.15, 0.15, 2.0, 2.0, 2.5),
                acceleration: Six::new(5.0, 1.0, 1.0, 8.0, 8.0, 10.0),
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

    /// Elevations \[rad\] of the upper arm and the forearm above the horizontal, as the closed linkages set them; `None`
    /// where the actuators' lengths in `q` close no loop.
    #[must_use]
    pub fn elevations(q: &Six) -> Option<[f64; 2]> {
        Linkage::of(q[1], q[2]).map(|l| [l.upper.y.atan2(l.upper.x), l.forearm.y.atan2(l.forearm.x)])
    }

    /// Joint positions from the elevations of the links instead of the actuators' lengths: `theta = (q1, theta2, theta3,
    /// q4, q5, q6)` \[rad\]; `None` where the linkages cannot be assembled so.
    #[must_use]
    pub fn from_elevations(theta: &Six) -> Option<Six> {
        let direction = |angle: f64| Vector2::new(angle.cos(), angle.sin());
        let (q2, q3) = Linkage::lengths(&direction(theta[1]), &direction(theta[2])).ok()?;
        Some(Six::new(theta[0], q2, q3, theta[3], theta[4], theta[5]))
    }

    /// The two wrists for a flange turned by `R_BF`, with the column turned by theta1 (cosine `c1`, sine `s1`) and the
    /// forearm along `forearm`: first the one with sin q5 >= 0. On the singularity one alone, which keeps q4.
    #[inline]
    #[allow(non_snake_case)]
    fn wrists(
        R_BF: &nalgebra::Matrix3<f64>,
        c1: f64,
        s1: f64,
        forearm: &Vector2<f64>,
        near: &Six,
    ) -> [Option<Wrist>; 2] {
        // Axes of the forearm: z along it, x downwards of it, y to the left.
        let (cf, sf) = (forearm.x, forearm.y);
        let forwards = |c: usize| c1 * R_BF[(0, c)] + s1 * R_BF[(1, c)];
        let x = |c: usize| sf * forwards(c) - cf * R_BF[(2, c)];
        let y = |c: usize| c1 * R_BF[(1, c)] - s1 * R_BF[(0, c)];
        let z = |c: usize| cf * forwards(c) + sf * R_BF[(2, c)];
        let (zx, zy, zz) = (x(2), y(2), z(2));
        let sine = zx.hypot(zy);
        let singular = sine < WRIST_SINGULAR;
        let (q4, (s4, c4)) =
            if singular { (near[3], near[3].sin_cos()) } else { (zy.atan2(zx), (zy / sine, zx / sine)) };
        // The axis of q5 in the flange's frame is (sin q6, cos q6, 0).
        let about = |c: usize| c4 * y(c) - s4 * x(c);
        let q6 = about(0).atan2(about(1));
        if singular {
            return [Some(Wrist { q4, q5: if zz > 0.0 { 0.0 } else { PI }, q6 }), None];
        }
        let q5 = sine.atan2(zz);
        [Some(Wrist { q4, q5, q6 }), Some(Wrist { q4: q4 + PI, q5: -q5, q6: q6 + PI })]
    }

    /// Visits the solutions of one side and elbow.
    #[inline]
    #[allow(non_snake_case)]
    fn solve(
        X_BF: &Pose,
        side: f64,
        elbow: f64,
        near: &Six,
        visit: &mut impl FnMut(&Six),
    ) -> Result<(), NoInverse> {
        let rotation = X_BF.rotation.to_rotation_matrix();
        let r = rotation.matrix();
        let centre = X_BF.translation.vector - D6 * r.column(2);
        let distance = centre.x.hypot(centre.y);
        if distance.is_nan() || distance < SHOULDER_SINGULAR {
            return Err(NoInverse::Singular { name: "shoulder" });
        }
        let c1 = side * centre.x / distance;
        let s1 = side * centre.y / distance;
        let reach = Vector2::new(side * distance - A1, centre.z - D1);
        let square = reach.norm_squared();
        let along = (square + A2 * A2 - A3 * A3) / (2.0 * square);
        let across = A2 * A2 / square - along * along;
        let refused = NoInverse::OutOfReach { distance: square.sqrt(), min: A3 - A2, max: A3 + A2 };
        if across.is_nan() || across < 0.0 {
            return Err(refused);
        }
        let upper = (reach * along + left(&reach) * (elbow * across.sqrt())) * (1.0 / A2);
        let forearm = (reach - upper * A2) * (1.0 / A3);
        let (q2, q3) = Linkage::lengths(&upper, &forearm)?;
        let theta1 = s1.atan2(c1);
        for wrist in Self::wrists(r, c1, s1, &forearm, near).into_iter().flatten() {
            visit(&Six::new(
                closest(theta1, near[0]),
                q2,
                q3,
                closest(wrist.q4, near[3]),
                closest(wrist.q5, near[4]),
                closest(wrist.q6, near[5]),
            ));
        }
        Ok(())
    }
}

impl Default for Rnt {
    fn default() -> Self {
        Self::new()
    }
}

impl Robot for Rnt {
    const KIND: &'static str = "rnt";

    type Joints = Six;

    fn joint(&self, i: usize) -> JointKind {
        if i == 1 || i == 2 { JointKind::Prismatic } else { JointKind::Revolute }
    }

    fn limits(&self) -> &Limits<Six> {
        &self.limits
    }

    fn coupled_limits(&self) -> Vec<String> {
        let transmission =
            format!("sine of the linkage's transmission angle: at least {:.3}", Self::TRANSMISSION);
        motor_limits_in_words(self).into_iter().chain([transmission]).collect()
    }

    fn check_coupled(&self, from: &Six, to: &Six, duration: f64) -> Result<(), CoupledLimit> {
        check_motors(self, from, to, duration)?;
        let actual = Linkage::of(to[1], to[2]).map_or(0.0, |linkage| linkage.transmission());
        if actual >= Self::TRANSMISSION {
            return Ok(());
        }
        let what = "sine of the linkage's transmission angle";
        Err(CoupledLimit { joint: 2, what, excess: Excess::new(actual, Self::TRANSMISSION, "") })
    }

    fn near_singularity(&self, q: &Six) -> Option<&'static str> {
        (q[4].sin().abs() < 0.1).then_some("near the wrist singularity")
    }

    /// Where the actuators' lengths close no loop (far outside the limits), NaN.
    fn forward(&self, q: &Six) -> Pose {
        let Some(Linkage { upper, forearm, .. }) = Linkage::of(q[1], q[2]) else {
            let nan = f64::NAN;
            let rotation = UnitQuaternion::new_unchecked(Quaternion::new(nan, nan, nan, nan));
            return Pose::from_parts(Translation3::new(nan, nan, nan), rotation);
        };
        let [h1, h5, plus, minus] = sin_cos([q[0], q[4], q[3] + q[5], q[3] - q[5]].map(|angle| 0.5 * angle));
        let ((s1, c1), (s5, c5)) = (doubled(h1), doubled(h5));
        let s4 = plus.0 * minus.1 + plus.1 * minus.0;
        let c4 = plus.1 * minus.1 - plus.0 * minus.0;
        // Half of the angle pi/2 - theta3, whose cosine and sine are the forearm's upward and forward parts, as a
        // direction whose length is divided off at the end, meanwhile computed.
        let square = 0.5 * (1.0 + forearm.y.abs());
        let part = 0.5 * forearm.x;
        let shorten = square.sqrt() * (1.0 / square);
        let (half_cosine, half_sine) =
            if forearm.y >= 0.0 { (square, part) } else { (part.abs(), square.copysign(part)) };
        let arm =
            Quaternion::new(h1.1 * half_cosine, -h1.0 * half_sine, h1.1 * half_sine, h1.0 * half_cosine);
        // R_z(q4) R_y(q5) R_z(q6), multiplied out.
        let wrist = Quaternion::new(h5.1 * plus.1, -h5.0 * minus.0, h5.0 * minus.1, h5.1 * plus.0);
        let rotation = UnitQuaternion::new_unchecked(arm * wrist * shorten);
        // z_F on the forearm's axes: x = (sf, -cf), z = (cf, sf) of the plane, y to the left.
        let (x, y, z) = (D6 * c4 * s5, D6 * s4 * s5, D6 * c5);
        let forwards = (A1 + A2 * upper.x) + (forearm.x * (A3 + z) + forearm.y * x);
        let up = (D1 + A2 * upper.y) + (forearm.y * (A3 + z) - forearm.x * x);
        let position = Translation3::new(c1 * forwards - s1 * y, s1 * forwards + c1 * y, up);
        self.base.X_WB * Pose::from_parts(position, rotation)
    }

    /// Visits the frames `X_WL` that the links carry, from base to flange: B, column, shoulder O, R, T, elbow E, wrist
    /// centre C, flange. Where the linkages cannot be closed, all but B and the flange are left out.
    fn frames(&self, q: &Six, visit: &mut dyn FnMut(&Pose)) {
        visit(&self.base.X_WB);
        if let Some(linkage) = Linkage::of(q[1], q[2]) {
            let arm = self.base.X_WB * Pose::rotation(Vector3::z() * q[0]);
            visit(&(arm * Translation3::new(0.0, 0.0, D1)));
            let at = |point: Vector2<f64>, x: &Vector2<f64>| {
                let turn = Pose::rotation(Vector3::y() * -x.y.atan2(x.x));
                arm * Translation3::new(A1 + point.x, 0.0, D1 + point.y) * turn
            };
            let elbow = linkage.upper * A2;
            let tip = linkage.rocker * ROCKER;
            visit(&at(Vector2::zeros(), &linkage.upper));
            visit(&at(tip, &linkage.rod));
            visit(&at(elbow - linkage.forearm * TAIL, &linkage.forearm));
            visit(&at(elbow, &linkage.forearm));
            visit(&at(elbow + linkage.forearm * A3, &linkage.forearm));
        }
        visit(&self.forward(q));
    }

    fn capsules_of_links(&self, q: &Six, visit: &mut dyn FnMut([Vector3<f64>; 2], f64)) {
        Outline::capsules(self, q, &mut |capsule| visit(capsule.ends, capsule.radius));
    }

    #[allow(non_snake_case)]
    fn inverse(&self, X_WF: &Pose, near: &Six) -> Result<Six, NoInverse> {
        let mut best: Option<(f64, Six)> = None;
        Self::solve(&(self.base.X_BW * X_WF), 1.0, 1.0, near, &mut |q| {
            // Both solutions have the same first three joints: the wrist decides.
            let distance = (q - near).fixed_rows::<3>(3).norm_squared();
            if best.is_none_or(|(least, _)| distance < least) {
                best = Some((distance, *q));
            }
        })?;
        best.map(|(_, q)| q).ok_or(NoInverse::Singular { name: "wrist" })
    }

    fn urdf(&self, name: &str, tool: &Tool) -> Option<String> {
        self.exported(name, tool)
    }
}

/// Both wrists on each side of the column and of the elbow, where the linkages can be assembled so; [`Robot::inverse`]
/// keeps the shoulder in front and the elbow up, as the actuators' strokes do.
impl Kinematics<6> for Rnt {
    fn reach(&self) -> f64 {
        A1 + A2 + A3 + D6
    }

    fn jacobian(&self, q: &Six) -> Jacobian<6> {
        let Some(linkage) = Linkage::of(q[1], q[2]) else {
            return Jacobian::repeat(f64::NAN);
        };
        let (s1, c1) = q[0].sin_cos();
        let (s4, c4) = q[3].sin_cos();
        let (s5, c5) = q[4].sin_cos();
        let plane = |v: &Vector2<f64>| Vector3::new(c1 * v.x, s1 * v.x, v.y);
        let along = plane(&linkage.forearm);
        let down = -plane(&left(&linkage.forearm));
        let aside = Vector3::new(-s1, c1, 0.0);
        let z_f = c4 * s5 * down + s4 * s5 * aside + c5 * along;
        let tip = D6 * z_f;
        let centre = plane(&(Vector2::new(A1, D1) + linkage.upper * A2 + linkage.forearm * A3));
        // An elevation turns about -aside.
        let raised = -aside;
        let (theta2, theta3_by_2, theta3_by_3) = linkage.rates(q[1], q[2]);
        let by_upper = A2 * plane(&left(&linkage.upper));
        let by_forearm = A3 * plane(&left(&linkage.forearm)) + raised.cross(&tip);
        let about5 = c4 * aside - s4 * down;
        let columns = [
            (Vector3::z().cross(&(centre + tip)), Vector3::z()),
            (by_upper * theta2 + by_forearm * theta3_by_2, raised * theta3_by_2),
            (by_forearm * theta3_by_3, raised * theta3_by_3),
            (along.cross(&tip), along),
            (about5.cross(&tip), about5),
            (Vector3::zeros(), z_f),
        ];
        let turned = self.base.X_WB.rotation;
        Jacobian::from_columns(
            &columns.map(|(linear, angular)| column(&(turned * linear), &(turned * angular))),
        )
    }

    #[allow(non_snake_case)]
    fn solutions(&self, X_WF: &Pose, near: &Six, visit: &mut dyn FnMut(&Six)) -> Result<(), NoInverse> {
        let X_BF = self.base.X_BW * X_WF;
        let mut refused = None;
        let mut any = false;
        for (side, elbow) in [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)] {
            let mut visit = |q: &Six| {
                any = true;
                visit(q);
            };
            if let Err(why) = Self::solve(&X_BF, side, elbow, near, &mut visit) {
                refused = refused.or(Some(why));
            }
        }
        refused.filter(|_| !any).map_or(Ok(()), Err)
    }
}

impl Driven<6> for Rnt {
    fn motor_data(&self) -> &[MotorData; 6] {
        &Self::MOTORS
    }

    fn motor_limits(&self) -> &MotorLimits<6> {
        &Self::MOTOR_LIMITS
    }

    /// The arm's tree has closed loops, so it is none in the joints: they are closed here.
    fn dynamics(&self) -> Option<Box<dyn Dynamics<6>>> {
        let tree = self.open_tree()?;
        Some(Box::new(masses::Closed(tree)))
    }

    fn motors(&self, q: &Six) -> Six {
        q.component_mul(&Six::from(Self::GEARS))
    }

    /// The weight reaches the actuators through the linkages: by the principle of virtual work.
    fn shafts(&self, angles: &Six, speeds: &Six) -> Shafts<6> {
        let gears = Six::from(Self::GEARS);
        let q = angles.component_div(&gears);
        let velocity = speeds.component_div(&gears);
        let mut loads = Six::zeros();
        if let Some(linkage) = Linkage::of(q[1], q[2]) {
            let (theta2, theta3_by_2, theta3_by_3) = linkage.rates(q[1], q[2]);
            let [m2, m3] = Self::GRAVITY_MOMENT;
            let upper = GRAVITY * m2 * linkage.upper.x;
            let forearm = GRAVITY * m3 * linkage.forearm.x;
            loads[1] = (upper * theta2 + forearm * theta3_by_2) / Self::GEARS[1];
            loads[2] = forearm * theta3_by_3 / Self::GEARS[2];
        }
        Shafts { joints: Measured { position: q, velocity }, loads }
    }
}
