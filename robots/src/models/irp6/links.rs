//! The links of the IRp-6, which all its variants share: the planar arm on the column, and the wrist.
//!
//! In: joint positions as [`Irp6`](super::Irp6) defines them, or the flange's pose in the arm's B. Out: the other, the
//! Jacobian and its determinant. The frames and the formulas stand there; the wrist is solved in `wrist.rs`.

use core::f64::consts::FRAC_PI_2;

use mrroc::pose::Pose;
use mrroc::robot::NoInverse;
use nalgebra::{Quaternion, Translation3, UnitQuaternion, Vector3};

use super::wrist::{Side, Wrist};
use crate::models::kinematics::{Jacobian, closest, column, doubled};
use crate::models::sines::sin_cos;
use crate::models::vectors::Six;

/// Lengths of the links.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Geometry {
    /// Lower link, shoulder to elbow \[m\].
    pub(crate) a2: f64,
    /// Upper link, elbow to T \[m\].
    pub(crate) a3: f64,
    /// Wrist link, T to the flange \[m\].
    pub(crate) d5: f64,
}

/// In which direction the elbow bends.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Elbow {
    /// `sin(theta3 - theta2) > 0`: the only direction that the linkages allow.
    Up,
    /// The other direction.
    Down,
}

impl Geometry {
    /// The design's dimensions.
    pub(crate) const NOMINAL: Self = Self { a2: 0.455, a3: 0.67, d5: 0.19 };

    /// Length of the stretched arm \[m\].
    pub(crate) fn length(&self) -> f64 {
        self.a2 + self.a3 + self.d5
    }

    /// `X_BF` at `q` \[rad\].
    #[inline]
    #[allow(non_snake_case)]
    pub(crate) fn flange(&self, q: &Six) -> Pose {
        let Geometry { a2, a3, d5 } = *self;
        let theta3 = q[1] + q[2] + FRAC_PI_2;
        let theta4 = theta3 + q[3];
        let [(s2, c2), (s3, c3), h1, h4, h5, h6] =
            sin_cos([q[1], theta3, 0.5 * q[0], 0.5 * theta4, 0.5 * q[4], 0.5 * q[5]]);
        let (s1, c1) = doubled(h1);
        let (s4, c4) = doubled(h4);
        let rho = a2 * c2 + a3 * c3 + d5 * c4;
        let position = Translation3::new(c1 * rho, s1 * rho, -a2 * s2 - a3 * s3 - d5 * s4);
        // R_z(q1) R_y(theta4), then R_x(q5) P R_z(q6), multiplied out.
        let arm = Quaternion::new(h1.1 * h4.1, -h1.0 * h4.0, h1.1 * h4.0, h1.0 * h4.1);
        let plus = 0.5 * (h5.1 + h5.0);
        let minus = 0.5 * (h5.1 - h5.0);
        let (sum, difference) = (h6.1 + h6.0, h6.1 - h6.0);
        let wrist = Quaternion::new(plus * sum, -minus * sum, -minus * difference, -plus * difference);
        let rotation = UnitQuaternion::new_unchecked(arm * wrist);
        Pose::from_parts(position, rotation)
    }

    /// The links' frames in B: shoulder, elbow, T, end of d5.
    pub(crate) fn links(&self, q: &Six, visit: &mut dyn FnMut(&Pose)) {
        let theta3 = q[1] + q[2] + FRAC_PI_2;
        let column = Pose::rotation(Vector3::z() * q[0]);
        visit(&column);
        let mut end = Vector3::zeros();
        let links = [(self.a2, q[1], theta3), (self.a3, theta3, theta3 + q[3])];
        for (length, angle, next) in links {
            end += length * Vector3::new(angle.cos(), 0.0, -angle.sin());
            visit(&(column * Pose::new(end, Vector3::y() * next)));
        }
        let wrist = Pose::new(end, Vector3::y() * (theta3 + q[3]));
        visit(&(column * wrist * Pose::new(Vector3::x() * self.d5, Vector3::x() * q[4])));
    }

    /// Jacobian at `q` \[rad\] of a flange seen in axes turned by `R_WB` from B.
    #[allow(non_snake_case)]
    pub(crate) fn jacobian(&self, q: &Six, R_WB: &UnitQuaternion<f64>) -> Jacobian<6> {
        let Geometry { a2, a3, d5 } = *self;
        let (theta2, theta3) = (q[1], q[1] + q[2] + FRAC_PI_2);
        let theta4 = theta3 + q[3];
        let (s1, c1) = q[0].sin_cos();
        let (s5, c5) = q[4].sin_cos();
        let (s4, c4) = theta4.sin_cos();
        // A link of length a turning downwards at 1 rad/s moves its far end by this.
        let swing = |a: f64, theta: f64| {
            let (sine, cosine) = theta.sin_cos();
            Vector3::new(-c1 * a * sine, -s1 * a * sine, -a * cosine)
        };
        let v4 = swing(d5, theta4);
        let v3 = v4 + swing(a3, theta3);
        let v2 = v3 + swing(a2, theta2);
        let rho = a2 * theta2.cos() + a3 * theta3.cos() + d5 * c4;
        let pitch = Vector3::new(-s1, c1, 0.0);
        let none = Vector3::zeros();
        let z_f = Vector3::new(c1 * s4 * s5 - s1 * c5, s1 * s4 * s5 + c1 * c5, c4 * s5);
        let columns = [
            (Vector3::new(-s1 * rho, c1 * rho, 0.0), Vector3::z()),
            (v2, pitch),
            (v3, pitch),
            (v4, pitch),
            (none, Vector3::new(c1 * c4, s1 * c4, -s4)),
            (none, z_f),
        ];
        Jacobian::from_columns(&columns.map(|(linear, angular)| column(&(R_WB * linear), &(R_WB * angular))))
    }

    /// |det J| at `q` \[m^3\].
    pub(crate) fn determinant(&self, q: &Six) -> f64 {
        let Geometry { a2, a3, d5 } = *self;
        let theta3 = q[1] + q[2] + FRAC_PI_2;
        let rho = a2 * q[1].cos() + a3 * theta3.cos() + d5 * (theta3 + q[3]).cos();
        (rho * a2 * a3 * (theta3 - q[1]).sin() * q[4].sin()).abs()
    }

    /// The solution with the shoulder in front and the elbow up whose wrist is nearest to `near`.
    #[inline]
    #[allow(non_snake_case)]
    pub(crate) fn nearest(&self, X_BF: &Pose, near: &Six) -> Result<Six, NoInverse> {
        let wrist = Wrist::of(X_BF, Side::Front, near)?;
        let flipped = wrist.flipped();
        let nearest = if wrist.distance(near) <= flipped.distance(near) { wrist } else { flipped };
        self.solve(&nearest, Elbow::Up, near)
    }

    /// Every solution once: shoulder in front and behind, both wrists, elbow up and down.
    #[allow(non_snake_case)]
    pub(crate) fn solutions(
        &self,
        X_BF: &Pose,
        near: &Six,
        visit: &mut dyn FnMut(&Six),
    ) -> Result<(), NoInverse> {
        let mut refused = None;
        let mut any = false;
        for side in [Side::Front, Side::Back] {
            let wrist = Wrist::of(X_BF, side, near)?;
            let both = [Some(wrist), wrist.other()];
            for wrist in both.into_iter().flatten() {
                for elbow in [Elbow::Up, Elbow::Down] {
                    match self.solve(&wrist, elbow, near) {
                        Ok(q) => {
                            any = true;
                            visit(&q);
                        }
                        Err(why) => refused = refused.or(Some(why)),
                    }
                }
            }
        }
        refused.filter(|_| !any).map_or(Ok(()), Err)
    }

    /// The planar two-link arm that carries a known wrist.
    #[inline]
    pub(super) fn solve(&self, wrist: &Wrist, elbow: Elbow, near: &Six) -> Result<Six, NoInverse> {
        let Geometry { a2, a3, d5 } = *self;
        // The far end of the upper arm: forwards and downwards from the shoulder.
        let e = wrist.rho - d5 * wrist.c4;
        let f = -wrist.z - d5 * wrist.s4;
        let (theta2, theta3) = two_links(a2, a3, e, f, elbow)?;
        Ok(Six::new(
            closest(wrist.theta1, near[0]),
            closest(theta2, near[1]),
            closest(theta3 - theta2 - FRAC_PI_2, near[2]),
            closest(wrist.theta4 - theta3, near[3]),
            closest(wrist.theta5, near[4]),
            closest(wrist.theta6, near[5]),
        ))
    }
}

/// Angles below the horizontal of two links of lengths `a2`, `a3` that reach from the shoulder to `e` forwards and `f`
/// downwards \[m\].
#[inline]
pub(crate) fn two_links(a2: f64, a3: f64, e: f64, f: f64, elbow: Elbow) -> Result<(f64, f64), NoInverse> {
    let square = e * e + f * f;
    let k = (square + a2 * a2 - a3 * a3) / (2.0 * a2);
    let under_root = square - k * k;
    if under_root.is_nan() || under_root < 0.0 {
        return Err(NoInverse::OutOfReach { distance: square.sqrt(), min: (a3 - a2).abs(), max: a2 + a3 });
    }
    if elbow == Elbow::Down && under_root == 0.0 {
        return Err(NoInverse::Singular { name: "elbow" });
    }
    let root = if elbow == Elbow::Up { under_root.sqrt() } else { -under_root.sqrt() };
    let (y, x) = (k * f - root * e, root * f + k * e);
    let (s2, c2) = (y / square, x / square);
    let theta2 = y.atan2(x);
    let theta3 = (f - a2 * s2).atan2(e - a2 * c2);
    Ok((theta2, theta3))
}
