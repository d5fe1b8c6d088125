//! Polycrank: seven joints that turn without end; three upright axes, three level ones, and the tool's own.
//!
//! ```text
//!   side view                       z7 = tool            plan view
//!      k |        o--L--o                                   y ^    P12
//!        |   L  /  (q5)  \ (q6) 0.043                         |   o------> e (phi = q1 + q2 + q3)
//!        | (q4)o          +---> F                             |  / a2 (q2)
//!        +-----|--> e     wrist centre                        | /
//!              |                                              |o
//!     a1  a2   | 1.632 m above the floor                      o--- a1 = -0.299 (q1): backwards
//!   (q1)(q2)(q3)                                              B --> x
//! ```
//!
//! **Frames.** B: on the floor in the axis of joint 1, z_B up. F: Denavit-Hartenberg frame 7. Rows (d, a \[m\], alpha):
//! (0.220, -0.299, 0), (0.152, 0.180, 0), (0.335, 0, 90 deg), (0.120, 0.151, 0), (0.116, 0.151, 0), (0.060, 0, 90 deg),
//! (0.043, 0, 0), on a column of 0.925 m; `A_i = R_z(q_i) T_z(d) T_x(a) R_x(alpha)`. With `phi = q1 + q2 + q3`,
//! `psi = q4 + q5 + q6`, `e = (cos phi, sin phi, 0)`, `m = (sin phi, -cos phi, 0)`, `k` up:
//!
//! ```text
//! p = P12 + 1.632 k + u e + v k + 0.296 m + 0.043 z_F,       P12 = a1 e(q1) + a2 e(q1 + q2)
//! u = L (cos q4 + cos(q4 + q5)),   v = L (sin q4 + sin(q4 + q5)),   z_F = sin(psi) e - cos(psi) k
//! ```
//!
//! **Redundancy.** The pose gives phi and psi (twice: the other turns both, and q7, half round), q7 and v; the *stretch*
//! `u` \[m\], how far the arm with the level axes reaches out along e, is free: `u = 0.302` were that arm level and
//! straight, `u = 0` puts the tool's joint above or below its shoulder. [`Robot::inverse_at`] takes `u` as a parameter of
//! the pose. [`Robot::inverse`] **keeps the stretch of `near`** and its elbows (signs of sin q2 and sin q5): one evaluation
//! in closed form, and a closed path of the flange brings the arm back to the joints that it started from. It minimises
//! nothing: where the arms are bent, another stretch may need less motion of the joints.
//!
//! Where a kept stretch would stretch or fold an arm (the sine of an elbow below 0.3), `u` changes, ever more, as the least
//! motion of the joints (sum of squares) changes it; below 0.15, and where an arm does not close at all, wholly so: by damped
//! Gauss-Newton steps on the closed-form solution. Any `u` gives the pose exactly: an error of the iteration changes only
//! how small the motion of the joints is. A closed path that comes near such places ends with another stretch: give `u`
//! there. An elbow that is nearly stretched may change its sign. The joints' speeds follow those of the path
//! continuously, except where a singularity leaves no choice: the tool vertical (`sin psi = 0`; phi then stays as in
//! `near`), both directions of changing `u` blocked (`sin q2 = sin q5 = 0`). Where the range of `u` ends so, a pose within 2 mm
//! and 2 mrad of `near`'s that needs the joints to move by more than 0.5 rad is refused as singular, not jumped to. Where the
//! heading nearest to `near` does not reach, the pose is refused rather than the arm turned over;
//! [`Kinematics::nearest_attainable`] tries all families.
//!
//! **Limits.** None on positions but the ±3600 deg of the published model: angles unwrap, and inverse takes the turn
//! nearest to `near`. 1 rad/s (its default velocity); 2 rad/s² is assumed.
//!
//! Sources: GraspIt!'s model of Polycrank (geometry, joint range), MRROC++ public facts (2250 motor turns per turn of each
//! joint, no limits). Its motors are assumed.

mod heading;
mod masses;
mod outline;

use core::f64::consts::{PI, TAU};

use mrroc::prelude::*;
use mrroc::robot::{CoupledLimit, Limits, Measured, NoInverse, Tool};
use nalgebra::{Quaternion, Translation3, UnitQuaternion, Vector3};

use crate::dynamics::Tree;
use crate::models::base::Base;
use crate::models::drives::{
    Driven, Encoder, GRAVITY, MotorData, MotorLimits, Shafts, check_motors, motor_limits_in_words,
};
use crate::models::kinematics::{Jacobian, Kinematics, column, doubled};
use crate::models::shape::Outline;
use crate::models::sines::sin_cos;
use crate::models::urdf::export::exported;
use crate::models::vectors::Seven;
use heading::{Heading, Least, Member, stretch_and_elbows};

const A1: f64 = -0.299;
const A2: f64 = 0.180;
/// Both links of the arm with level axes \[m\].
const L: f64 = 0.151;
/// Height of the level axes at v = 0 \[m\].
const HEIGHT: f64 = 0.925 + 0.220 + 0.152 + 0.335;
/// Offset along the level axes \[m\].
const ASIDE: f64 = 0.120 + 0.116 + 0.060;
/// From the wrist centre to the flange \[m\].
const TIP: f64 = 0.043;

/// Sine of an elbow below which its other side is tried too.
const ELBOW: f64 = 0.05;
/// Motion of the joints that counts as a jump when the flange moves by less than [`BESIDE`] \[rad\].
const JUMP: f64 = 0.5;
/// Motion of the flange below which a large motion of the joints is a jump [m and rad].
const BESIDE: f64 = 2e-3;

/// A Polycrank arm.
#[derive(Clone, Debug, PartialEq)]
pub struct Polycrank {
    base: Base,
    limits: Limits<Seven>,
}

impl Polycrank {
    /// Motor turns per joint turn (MRROC++).
    pub const GEAR: f64 = 2250.0;

    /// First moments of mass that load joints 4, 5 and 6, after balancing [kg m] (assumed).
    pub const GRAVITY_MOMENT: [f64; 3] = [0.6, 0.3, 0.1];
    /// The drive of every joint: a small, fast motor. All figures are assumed; gear and encoder must fit 1 rad/s,
    /// 2250 rad/s at the motor, so it has the 128 pulses per turn of MRROC++'s grippers. The loop's gain is that of the
    /// IRp-6's column.
    pub const MOTOR: MotorData = MotorData {
        encoder: Encoder { pulses: 128.0 },
        current_limit: 6.0,
        resistance: 1.46,
        torque_constant: 0.02,
        inertia: 2e-5,
        viscous: 1e-6,
        coulomb: 2e-3,
        following: 20.0,
        brake: 2e4,
        ..MotorData::DISC
    };
    const MOTOR_LIMITS: MotorLimits<7> =
        MotorLimits { lower: [-142_000.0; 7], upper: [142_000.0; 7], speed: 2500.0 };

    /// The arm with its base at the world's origin.
    #[must_use]
    pub fn new() -> Self {
        Self {
            base: Base::default(),
            limits: Limits {
                lower: Seven::repeat(-10.0 * TAU),
                upper: Seven::repeat(10.0 * TAU),
                velocity: Seven::repeat(1.0),
                acceleration: Seven::repeat(2.0),
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

    /// How far `q` stretches the arm with the level axes: the redundancy's parameter u \[m\], -0.302 to 0.302.
    #[must_use]
    pub fn stretch(q: &Seven) -> f64 {
        stretch_and_elbows(q).0
    }

    /// Inverse kinematics where an elbow is nearly stretched or folded at the stretch `u` of `near`, or does not close.
    #[cold]
    #[allow(non_snake_case)]
    fn inverse_past_elbows(
        &self,
        X_WF: &Pose,
        heading: &Heading,
        u: f64,
        kept: &Member,
        near: &Seven,
    ) -> Result<Seven, NoInverse> {
        let ranges = heading.ranges()?;
        let (_, elbows) = stretch_and_elbows(near);
        let mut best: Option<Least> = None;
        for (flip2, flip5) in [(false, false), (true, false), (false, true), (true, true)] {
            if (flip2 && near[1].sin().abs() > ELBOW) || (flip5 && near[4].sin().abs() > ELBOW) {
                continue;
            }
            let sign = |flip: bool| if flip { -1.0 } else { 1.0 };
            let found = heading.settle(&ranges, u, [elbows[0] * sign(flip2), elbows[1] * sign(flip5)], near);
            best = match (best, found) {
                (Some(best), Some(found)) if best.distance <= found.distance => Some(best),
                (best, found) => found.or(best),
            };
        }
        let stretched = NoInverse::Singular { name: "stretched arms" };
        let q = heading.between(u, kept, &best.ok_or(stretched)?, elbows, near);
        // The range of u that near lies in has vanished: going on would be a jump into another.
        if (q - near).norm_squared() > JUMP * JUMP && self.is_beside(X_WF, near) {
            Err(stretched)
        } else {
            Ok(q)
        }
    }

    /// Whether the flange at `near` is within [`BESIDE`] of `X_WF`.
    #[cold]
    #[allow(non_snake_case)]
    fn is_beside(&self, X_WF: &Pose, near: &Seven) -> bool {
        let here = self.forward(near);
        (here.translation.vector - X_WF.translation.vector).norm() < BESIDE
            && here.rotation.angle_to(&X_WF.rotation) < BESIDE
    }
}

impl Default for Polycrank {
    fn default() -> Self {
        Self::new()
    }
}

impl Robot for Polycrank {
    const KIND: &'static str = "polycrank";

    type Joints = Seven;

    fn limits(&self) -> &Limits<Seven> {
        &self.limits
    }

    fn coupled_limits(&self) -> Vec<String> {
        motor_limits_in_words(self)
    }

    fn check_coupled(&self, from: &Seven, to: &Seven, duration: f64) -> Result<(), CoupledLimit> {
        check_motors(self, from, to, duration)
    }

    fn near_singularity(&self, q: &Seven) -> Option<&'static str> {
        let [tool, elbow2, elbow5] = [q[3] + q[4] + q[5], q[1], q[4]].map(|angle| angle.sin().abs() < 0.1);
        match (tool, elbow2 || elbow5) {
            (true, _) => Some("near the vertical-tool singularity"),
            (false, true) => Some("with an elbow stretched or folded"),
            (false, false) => None,
        }
    }

    fn forward(&self, q: &Seven) -> Pose {
        let (q12, q45) = (q[0] + q[1], q[3] + q[4]);
        let (phi, psi) = (q12 + q[2], q45 + q[5]);
        let sum = 0.5 * (phi + q[6]);
        let difference = 0.5 * (phi - q[6]);
        let [(s1, c1), (s12, c12), (s4, c4), (s45, c45), (sp, cp), h, plus, minus] =
            sin_cos([q[0], q12, q[3], q45, phi, 0.5 * psi, sum, difference]);
        let (ss, cs) = doubled(h);
        let u = L * (c4 + c45) + TIP * ss;
        let v = L * (s4 + s45) - TIP * cs;
        let position = Translation3::new(
            A1 * c1 + A2 * c12 + u * cp + ASIDE * sp,
            A1 * s1 + A2 * s12 + u * sp - ASIDE * cp,
            HEIGHT + v,
        );
        // R_z(phi) R_x(90 deg) R_z(psi) R_x(90 deg) R_z(q7), multiplied out.
        let rotation = Quaternion::new(-h.0 * plus.0, h.1 * minus.1, h.1 * minus.0, h.0 * plus.1);
        self.base.X_WB * Pose::from_parts(position, UnitQuaternion::new_unchecked(rotation))
    }

    /// Visits the frames `X_WL` that the links carry, from base to flange: B, then Denavit-Hartenberg frames 1 to 7; the
    /// elbow of a joint's offset `d` and length `a` lies between them.
    fn frames(&self, q: &Seven, visit: &mut dyn FnMut(&Pose)) {
        let rows = [
            (0.925 + 0.220, A1, 0.0),
            (0.152, A2, 0.0),
            (0.335, 0.0, 0.5 * PI),
            (0.120, L, 0.0),
            (0.116, L, 0.0),
            (0.060, 0.0, 0.5 * PI),
            (TIP, 0.0, 0.0),
        ];
        let mut frame = self.base.X_WB;
        visit(&frame);
        for (i, (d, a, alpha)) in rows.into_iter().enumerate() {
            frame *= Pose::new(Vector3::z() * d, Vector3::z() * q[i]);
            frame *= Pose::new(Vector3::x() * a, Vector3::x() * alpha);
            visit(&frame);
        }
    }

    fn capsules_of_links(&self, q: &Seven, visit: &mut dyn FnMut([Vector3<f64>; 2], f64)) {
        Outline::capsules(self, q, &mut |capsule| visit(capsule.ends, capsule.radius));
    }

    #[allow(non_snake_case)]
    fn inverse(&self, X_WF: &Pose, near: &Seven) -> Result<Seven, NoInverse> {
        let heading = Heading::of(&(self.base.X_BW * X_WF), near)?.nearest(near);
        let (u, elbows) = stretch_and_elbows(near);
        let kept = heading.member(u, elbows, near);
        if kept.share() > 0.0 { self.inverse_past_elbows(X_WF, &heading, u, &kept, near) } else { Ok(kept.q) }
    }

    /// `redundancy`: the stretch u \[m\], -0.302 to 0.302, see [`Polycrank`]; heading and elbows as in `near`.
    ///
    /// # Errors
    /// [`NoInverse::OutOfReach`] when one of the two arms cannot stretch or fold so far: with its distance and its reach.
    #[allow(non_snake_case)]
    fn inverse_at(&self, X_WF: &Pose, redundancy: f64, near: &Seven) -> Result<Seven, NoInverse> {
        let heading = Heading::of(&(self.base.X_BW * X_WF), near)?.nearest(near);
        heading.check(redundancy)?;
        Ok(heading.member(redundancy, stretch_and_elbows(near).1, near).q)
    }

    fn urdf(&self, name: &str, tool: &Tool) -> Option<String> {
        exported(self, name, tool)
    }
}

/// One solution of each of the eight families (two headings, two elbows): the one that [`Robot::inverse`] would take.
impl Kinematics<7> for Polycrank {
    fn reach(&self) -> f64 {
        A1.abs() + A2 + 2.0 * L + ASIDE
    }

    fn jacobian(&self, q: &Seven) -> Jacobian<7> {
        let (phi, psi) = (q[0] + q[1] + q[2], q[3] + q[4] + q[5]);
        let ((sp, cp), (ss, cs)) = (phi.sin_cos(), psi.sin_cos());
        let (s1, c1) = q[0].sin_cos();
        let (s12, c12) = (q[0] + q[1]).sin_cos();
        let (s4, c4) = q[3].sin_cos();
        let (s45, c45) = (q[3] + q[4]).sin_cos();
        let e = Vector3::new(cp, sp, 0.0);
        let k = Vector3::z();
        let m = Vector3::new(sp, -cp, 0.0);
        // From each axis to the flange.
        let from6 = TIP * (ss * e - cs * k);
        let from5 = from6 + L * (c45 * e + s45 * k);
        let from4 = from5 + L * (c4 * e + s4 * k);
        let from3 = from4 + ASIDE * m;
        let from2 = from3 + A2 * Vector3::new(c12, s12, 0.0);
        let from1 = from2 + A1 * Vector3::new(c1, s1, 0.0);
        let none = Vector3::zeros();
        let z_f = ss * e - cs * k;
        let axes = [(k, from1), (k, from2), (k, from3), (m, from4), (m, from5), (m, from6), (z_f, none)];
        let turned = self.base.X_WB.rotation;
        Jacobian::from_columns(
            &axes.map(|(axis, arm)| column(&(turned * axis.cross(&arm)), &(turned * axis))),
        )
    }

    #[allow(non_snake_case)]
    fn solutions(&self, X_WF: &Pose, near: &Seven, visit: &mut dyn FnMut(&Seven)) -> Result<(), NoInverse> {
        let first = Heading::of(&(self.base.X_BW * X_WF), near)?;
        let (u, _) = stretch_and_elbows(near);
        let mut refused = None;
        let mut any = false;
        for heading in [Some(first), first.other()].into_iter().flatten() {
            match heading.ranges() {
                Ok(ranges) => {
                    for elbows in [[1.0, 1.0], [-1.0, 1.0], [1.0, -1.0], [-1.0, -1.0]] {
                        let kept = heading.member(u, elbows, near);
                        let q = if kept.share() > 0.0 {
                            let least = heading.settle(&ranges, u, elbows, near);
                            least.map(|least| heading.between(u, &kept, &least, elbows, near))
                        } else {
                            Some(kept.q)
                        };
                        if let Some(q) = q {
                            any = true;
                            visit(&q);
                        }
                    }
                }
                Err(why) => refused = refused.or(Some(why)),
            }
        }
        refused.filter(|_| !any).map_or(Ok(()), Err)
    }
}

impl Driven<7> for Polycrank {
    fn motor_data(&self) -> &[MotorData; 7] {
        &[Self::MOTOR; 7]
    }

    fn motor_limits(&self) -> &MotorLimits<7> {
        &Self::MOTOR_LIMITS
    }

    fn tree(&self) -> Option<Tree<7>> {
        self.bodies()
    }

    fn motors(&self, q: &Seven) -> Seven {
        q * Self::GEAR
    }

    fn shafts(&self, angles: &Seven, speeds: &Seven) -> Shafts<7> {
        let q = angles / Self::GEAR;
        let qdot = speeds / Self::GEAR;
        // Each moment turns with all joints before it, so each joint carries those behind it.
        let [m4, m5, m6] = Self::GRAVITY_MOMENT;
        let g4 = m4 * q[3].cos();
        let g5 = m5 * (q[3] + q[4]).cos();
        let g6 = m6 * (q[3] + q[4] + q[5]).cos();
        let share = GRAVITY / Self::GEAR;
        let loads = Seven::from([0.0, 0.0, 0.0, share * (g4 + g5 + g6), share * (g5 + g6), share * g6, 0.0]);
        Shafts { joints: Measured { position: q, velocity: qdot }, loads }
    }
}
