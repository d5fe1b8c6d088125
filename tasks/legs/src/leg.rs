//! A leg: three joints that move a foot in the frame of the trunk.
//!
//! ```text
//!  T: the trunk, x ahead, y to the left, z up          B: the hip, with the axes of T where the base is not turned
//!
//!     q0  about x of B: abduction        side d along y of B        side: +1 left, -1 right
//!     q1  about y: hip pitch             thigh, 0.28 m down at 0
//!     q2  about y: knee                  shank, 0.28 m down at 0; F at its end, in the middle of the foot
//!
//!     u = -l1 sin q1 - l2 sin(q1 + q2)        w = -l1 cos q1 - l2 cos(q1 + q2)        p_BF = Rx(q0) (u, side d, w)
//! ```
//!
//! **Flange.** F has the axes of the base: the foot is a pad on a free ball joint, so it has no attitude of its own. A pose that
//! is turned by more than [`Leg::OFF`] is refused. **Inverse.** Closed form, four solutions: the foot below or above the hip's pitch
//! axis, the knee bent backwards (`q2 < 0`) or forwards. `Robot::inverse` stays on the branch of its seed; the joint limits hold the foot
//! below and the knee backwards, so a demand on another branch is refused by the limit of a joint. **Singularities.** A straight
//! knee, a folded one, and a foot at the height of the hip's pitch axis.
//!
//! All dimensions, masses and motors are assumed: a machine of 28 kg.

use mrroc::prelude::*;
use mrroc::robot::{CoupledLimit, Limits, Load, Measured, NoInverse};
use mrroc_robots::dynamics::{Segment, Tree};
use mrroc_robots::{Driven, Encoder, Gains, Jacobian, Kinematics, MotorData, MotorLimits, Overload, Shafts};
use nalgebra::{Matrix3, Rotation3, Translation3, UnitQuaternion, Vector3};

/// Joint positions of a leg \[rad\].
pub type Three = Vector3<f64>;

/// Gravity [m/s²].
pub const GRAVITY: f64 = 9.80665;

/// A leg on a trunk. Its world is the trunk: its base, its poses and its Jacobian are told in T.
#[derive(Clone, Debug, PartialEq)]
#[allow(non_snake_case)]
pub struct Leg {
    X_TB: Pose,
    X_BT: Pose,
    side: f64,
    limits: Limits<Three>,
}

/// A link of a leg in motion, in the axes of T and relative to it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Link {
    /// \[kg\].
    pub mass: f64,
    /// Its centre of mass [m, T].
    pub at: Vector3<f64>,
    /// How that moves [m/s, T].
    pub velocity: Vector3<f64>,
    /// Inertia about its centre of mass, along the axes of T [kg m²].
    pub inertia: Matrix3<f64>,
    /// How it turns [rad/s, T].
    pub turning: Vector3<f64>,
}

/// A point of the leg: `Rx(q0) (.., y, ..)`, so far down the thigh and the shank \[m\].
#[derive(Clone, Copy, Debug)]
struct Point {
    y: f64,
    thigh: f64,
    shank: f64,
}

impl Leg {
    /// Largest turn of a demanded pose \[rad\].
    pub const OFF: f64 = 1e-6;
    /// From the hip's abduction axis to the plane of thigh and shank \[m\].
    pub const ASIDE: f64 = 0.09;
    /// Length of the thigh, and of the shank \[m\].
    pub const THIGH: f64 = 0.28;
    /// See [`THIGH`](Self::THIGH).
    pub const SHANK: f64 = 0.28;
    /// Masses of the hip, the thigh and the shank with its foot \[kg\].
    pub const MASSES: [f64; 3] = [0.8, 1.0, 0.3];
    /// Turns of a motor for one of its joint.
    pub const GEAR: f64 = 50.0;
    /// The motor of each joint. Its inertia is that of the rotor and a share of the links; the links' coupling is left out.
    pub const MOTOR: MotorData = MotorData {
        encoder: Encoder { pulses: 4000.0 },
        gains: Gains { a: 0.429, b0: 0.85, b1: 0.793, feedforward: 0.4176 },
        current_limit: 10.0,
        resistance: 2.0,
        torque_constant: 0.20,
        inertia: 1.6e-4,
        viscous: 2e-5,
        coulomb: 0.02,
        following: 2.0,
        brake: 15_000.0,
        overload: Overload::Trip,
    };
    const LOWER: [f64; 3] = [-0.7, -0.9, -2.5];
    const UPPER: [f64; 3] = [0.7, 2.0, -0.2];
    const MOTOR_LIMITS: MotorLimits<3> = MotorLimits {
        lower: [-0.71 * Self::GEAR, -0.91 * Self::GEAR, -2.51 * Self::GEAR],
        upper: [0.71 * Self::GEAR, 2.01 * Self::GEAR, -0.19 * Self::GEAR],
        speed: 400.0,
    };
    /// Where the links' centres of mass are: along the hip's link, down the thigh, down the shank \[m\].
    pub const CENTRES: [f64; 3] = [0.03, 0.10, 0.12];

    /// The leg whose hip stands at `X_TB` in the trunk: a left one where y is positive there, else a right one.
    #[must_use]
    #[allow(non_snake_case)]
    pub fn at(X_TB: Pose) -> Self {
        Self {
            side: if X_TB.translation.y > 0.0 { 1.0 } else { -1.0 },
            X_BT: X_TB.inverse(),
            X_TB,
            limits: Limits {
                lower: Self::LOWER.into(),
                upper: Self::UPPER.into(),
                velocity: Vector3::repeat(7.5),
                acceleration: Vector3::repeat(200.0),
                jerk: None,
            },
        }
    }

    /// +1 of a left leg, -1 of a right one.
    #[must_use]
    pub const fn side(&self) -> f64 {
        self.side
    }

    /// Where the foot is [m, T].
    #[must_use]
    pub fn foot(&self, q: &Three) -> Vector3<f64> {
        self.X_TB.transform_point(&self.foot_point().place(q).into()).coords
    }

    /// How the foot moves with each joint, by columns [m/rad, T].
    #[must_use]
    pub fn slope(&self, q: &Three) -> Matrix3<f64> {
        self.X_TB.rotation.to_rotation_matrix() * self.foot_point().slope(q)
    }

    /// The joint positions that put the foot at `p` [m, T], on the branch nearest to `near`.
    ///
    /// # Errors
    /// [`NoInverse`] where the foot cannot be there.
    pub fn reach_for(&self, p: &Vector3<f64>, near: &Three) -> Result<Three, NoInverse> {
        let mut best: Option<(f64, Three)> = None;
        self.all(p, near, &mut |q| {
            let far = (q - near).norm_squared();
            if best.is_none_or(|(least, _)| far < least) {
                best = Some((far, *q));
            }
        })?;
        best.map(|(_, q)| q).ok_or(NoInverse::Singular { name: "folded knee" })
    }

    /// Its links, at joint positions `q` \[rad\] and speeds `qd` [rad/s].
    #[must_use]
    pub fn links(&self, q: &Three, qd: &Three) -> [Link; 3] {
        let turned = self.X_TB.rotation;
        let abduction = Rotation3::from_axis_angle(&Vector3::x_axis(), q[0]);
        let pitch = |angle| abduction * Rotation3::from_axis_angle(&Vector3::y_axis(), angle);
        let about = [Vector3::x() * qd[0], abduction * Vector3::y()];
        let attitudes = [abduction, pitch(q[1]), pitch(q[1] + q[2])];
        let turning = [about[0], about[0] + about[1] * qd[1], about[0] + about[1] * (qd[1] + qd[2])];
        core::array::from_fn(|i| {
            let point = self.centre(i);
            let attitude = turned.to_rotation_matrix() * attitudes[i];
            Link {
                mass: Self::MASSES[i],
                at: self.X_TB.transform_point(&point.place(q).into()).coords,
                velocity: turned * (point.slope(q) * qd),
                inertia: attitude * Self::inertia(i) * attitude.inverse(),
                turning: turned * turning[i],
            }
        })
    }

    /// The sum of mass and place of its centre of mass [kg m, T].
    #[must_use]
    pub fn moment(&self, q: &Three) -> Vector3<f64> {
        (0..3)
            .map(|i| self.X_TB.transform_point(&self.centre(i).place(q).into()).coords * Self::MASSES[i])
            .sum()
    }

    /// Inertia of a link about its centre, along its own axes [kg m²]: a ball for the hip, rods.
    fn inertia(i: usize) -> Matrix3<f64> {
        let rod =
            |m: f64, l: f64| Matrix3::from_diagonal(&Vector3::new(m * l * l / 12.0, m * l * l / 12.0, 4e-4));
        match i {
            0 => Matrix3::identity() * 8e-4,
            1 => rod(Self::MASSES[1], Self::THIGH),
            _ => rod(Self::MASSES[2], Self::SHANK),
        }
    }

    const fn foot_point(&self) -> Point {
        Point { y: self.side * Self::ASIDE, thigh: Self::THIGH, shank: Self::SHANK }
    }

    /// The centre of mass of a link.
    const fn centre(&self, i: usize) -> Point {
        let y = self.side * Self::ASIDE;
        match i {
            0 => Point { y: self.side * Self::CENTRES[0], thigh: 0.0, shank: 0.0 },
            1 => Point { y, thigh: Self::CENTRES[1], shank: 0.0 },
            _ => Point { y, thigh: Self::THIGH, shank: Self::CENTRES[2] },
        }
    }

    /// Visits all joint positions that put the foot at `p` [m, T].
    fn all(&self, p: &Vector3<f64>, near: &Three, visit: &mut dyn FnMut(&Three)) -> Result<(), NoInverse> {
        let p = self.X_BT.transform_point(&(*p).into()).coords;
        let refused =
            |what, actual, tolerance| Err(NoInverse::NotAttainable { what, actual, tolerance, unit: "m" });
        let aside = self.side * Self::ASIDE;
        let square = p.y * p.y + p.z * p.z - aside * aside;
        if !p.iter().all(|x| x.is_finite()) {
            return refused("distance of the foot from the hip", f64::INFINITY, Self::THIGH + Self::SHANK);
        }
        if square < 0.0 {
            let inside = Self::ASIDE - p.y.hypot(p.z);
            return refused("how far the foot is inside of the circle of the hip", inside, 0.0);
        }
        let far = (p.x * p.x + square).sqrt();
        if far > Self::THIGH + Self::SHANK {
            return refused("distance of the foot from the hip", far, Self::THIGH + Self::SHANK);
        }
        if far <= (Self::THIGH - Self::SHANK).abs() + 1e-6 {
            return Err(NoInverse::Singular { name: "folded knee" });
        }
        let (a, b) = (Self::THIGH, Self::SHANK);
        let bend = ((far * far - a * a - b * b) / (2.0 * a * b)).clamp(-1.0, 1.0).acos();
        for w in [-square.sqrt(), square.sqrt()] {
            let abduction = p.z.atan2(p.y) - w.atan2(aside);
            for knee in [-bend, bend] {
                let pitch = (-p.x).atan2(-w) - (b * knee.sin()).atan2(a + b * knee.cos());
                visit(&Three::new(
                    closest(abduction, near[0]),
                    closest(pitch, near[1]),
                    closest(knee, near[2]),
                ));
            }
        }
        Ok(())
    }
}

impl Point {
    /// Where it is at `q` [m, B].
    fn place(&self, q: &Three) -> Vector3<f64> {
        let (s0, c0) = q[0].sin_cos();
        let (u, w) = self.plane(q);
        Vector3::new(u, self.y * c0 - w * s0, self.y * s0 + w * c0)
    }

    /// In the leg's plane: ahead, and up \[m\].
    fn plane(&self, q: &Three) -> (f64, f64) {
        let ((s1, c1), (s12, c12)) = (q[1].sin_cos(), (q[1] + q[2]).sin_cos());
        (-self.thigh * s1 - self.shank * s12, -self.thigh * c1 - self.shank * c12)
    }

    /// Its derivatives by the joints, by columns [m/rad, B].
    fn slope(&self, q: &Three) -> Matrix3<f64> {
        let (s0, c0) = q[0].sin_cos();
        let p = self.place(q);
        let (u, w) = self.plane(q);
        let (s12, c12) = (q[1] + q[2]).sin_cos();
        let (u2, w2) = (-self.shank * s12, -self.shank * c12);
        Matrix3::from_columns(&[
            Vector3::new(0.0, -p.z, p.y),
            Vector3::new(w, u * s0, -u * c0),
            Vector3::new(w2, u2 * s0, -u2 * c0),
        ])
    }
}

/// The angle equal to `angle` up to full turns that lies closest to `near` \[rad\].
fn closest(angle: f64, near: f64) -> f64 {
    let turn = core::f64::consts::TAU;
    angle - turn * ((angle - near) / turn).round()
}

impl Robot for Leg {
    const KIND: &'static str = "leg";

    type Joints = Three;

    fn limits(&self) -> &Limits<Three> {
        &self.limits
    }

    fn check_coupled(&self, from: &Three, to: &Three, duration: f64) -> Result<(), CoupledLimit> {
        for i in 0..3 {
            let (speed, limit) = ((to[i] - from[i]).abs() * Self::GEAR / duration, Self::MOTOR_LIMITS.speed);
            if speed > limit {
                let excess = mrroc::fault::Excess::new(speed, limit, "rad/s");
                return Err(CoupledLimit { joint: i, what: "speed of the motor", excess });
            }
        }
        Ok(())
    }

    fn near_singularity(&self, q: &Three) -> Option<&'static str> {
        if q[2].abs() < 0.15 {
            Some("straight knee")
        } else if self.foot_point().plane(q).1.abs() < 0.03 {
            Some("hip")
        } else {
            None
        }
    }

    fn forward(&self, q: &Three) -> Pose {
        self.X_TB * Translation3::from(self.foot_point().place(q))
    }

    /// Visits the frames `X_TL`: B, the hip's pitch axis, the knee, F.
    fn frames(&self, q: &Three, visit: &mut dyn FnMut(&Pose)) {
        visit(&self.X_TB);
        let attitude = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), q[0]);
        let y = self.side * Self::ASIDE;
        let mut turned = attitude;
        for (i, thigh) in [(1, 0.0), (2, Self::THIGH)] {
            turned *= UnitQuaternion::from_axis_angle(&Vector3::y_axis(), q[i]);
            let at = Point { y, thigh, shank: 0.0 }.place(q);
            visit(&(self.X_TB * Pose::from_parts(at.into(), turned)));
        }
        visit(&self.forward(q));
    }

    fn capsules_of_links(&self, q: &Three, visit: &mut dyn FnMut([Vector3<f64>; 2], f64)) {
        let mut before: Option<Vector3<f64>> = None;
        self.frames(q, &mut |frame| {
            let at = frame.translation.vector;
            if let Some(from) = before.replace(at) {
                visit([from, at], 0.025);
            }
        });
    }

    #[allow(non_snake_case)]
    fn inverse(&self, X_TF: &Pose, near: &Three) -> Result<Three, NoInverse> {
        self.check_attitude(X_TF)?;
        self.reach_for(&X_TF.translation.vector, near)
    }
}

impl Leg {
    #[allow(non_snake_case)]
    fn check_attitude(&self, X_TF: &Pose) -> Result<(), NoInverse> {
        let turn = (self.X_BT * X_TF).rotation.angle();
        if turn <= Self::OFF {
            return Ok(());
        }
        let what = "turn of a foot that has the trunk's axes";
        Err(NoInverse::NotAttainable { what, actual: turn, tolerance: Self::OFF, unit: "rad" })
    }
}

/// Four solutions.
impl Kinematics<3> for Leg {
    fn reach(&self) -> f64 {
        Self::THIGH + Self::SHANK
    }

    fn jacobian(&self, q: &Three) -> Jacobian<3> {
        let mut jacobian = Jacobian::<3>::zeros();
        jacobian.fixed_view_mut::<3, 3>(0, 0).copy_from(&self.slope(q));
        jacobian
    }

    #[allow(non_snake_case)]
    fn solutions(&self, X_TF: &Pose, near: &Three, visit: &mut dyn FnMut(&Three)) -> Result<(), NoInverse> {
        self.check_attitude(X_TF)?;
        self.all(&X_TF.translation.vector, near, visit)
    }
}

impl Driven<3> for Leg {
    fn motor_data(&self) -> &[MotorData; 3] {
        &[Self::MOTOR; 3]
    }

    fn motor_limits(&self) -> &MotorLimits<3> {
        &Self::MOTOR_LIMITS
    }

    fn motors(&self, q: &Three) -> Three {
        q * Self::GEAR
    }

    /// The links weigh on the motors as on a level trunk.
    fn shafts(&self, angles: &Three, speeds: &Three) -> Shafts<3> {
        let q = angles / Self::GEAR;
        let up = self.X_TB.rotation.inverse() * Vector3::z();
        let weight = |i| self.centre(i).slope(&q).tr_mul(&up) * Self::MASSES[i];
        let loads = (weight(0) + weight(1) + weight(2)) * (GRAVITY / Self::GEAR);
        Shafts { joints: Measured { position: q, velocity: speeds / Self::GEAR }, loads }
    }

    fn tree(&self) -> Option<Tree<3>> {
        let y = Vector3::y() * (self.side * Self::ASIDE);
        let body = |i: usize, centre: Vector3<f64>| Load {
            mass: Self::MASSES[i],
            centre,
            inertia: Self::inertia(i),
        };
        let down = |z: f64| Vector3::z() * -z;
        let segments = vec![
            Segment::turning("hip", None, 0, Vector3::zeros(), Vector3::x())
                .carrying(body(0, Vector3::y() * (self.side * Self::CENTRES[0]))),
            Segment::turning("thigh", Some(0), 1, y, Vector3::y()).carrying(body(1, down(Self::CENTRES[1]))),
            Segment::turning("shank", Some(1), 2, down(Self::THIGH), Vector3::y())
                .carrying(body(2, down(Self::CENTRES[2]))),
        ];
        Tree::new(self.X_TB, segments, Pose::translation(0.0, 0.0, -Self::SHANK)).ok()
    }
}
