//! The wrist of the IRp-6 from the pose of its flange.
//!
//! With the column at `theta1 = atan2(p_y, p_x)`, the vertical plane of the arm holds the axis of V; z_F is
//! perpendicular to that axis: `z_F = (s5 s4, c5, s5 c4)` in (forwards, sideways, up). Hence two solutions,
//! `(theta4, q5, q6)` and `(theta4 + pi, -q5, q6 + pi)`, and where `s5 = 0` infinitely many: there theta4 is kept.

use core::f64::consts::{FRAC_PI_2, PI};

use mrroc::pose::Pose;
use mrroc::robot::NoInverse;

use crate::models::kinematics::closest;
use crate::models::vectors::Six;

/// Distance of the flange from the column axis below which q1 is undetermined \[m\].
const SHOULDER_SINGULAR: f64 = 1e-9;

/// Sine of q5 below which the wrist counts as singular; the pose then errs by no more than this \[rad\].
const WRIST_SINGULAR: f64 = 1e-10;

/// To which side of the column the arm reaches.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Side {
    /// Towards `theta1`.
    Front,
    /// Over the column, away from `theta1`.
    Back,
}

/// What the flange pose alone determines: the column and one of the two wrist solutions.
#[derive(Clone, Copy)]
pub(crate) struct Wrist {
    /// Distance of the flange from the column axis \[m\]; below 0 behind the column.
    pub(crate) rho: f64,
    /// Height of the flange \[m\].
    pub(crate) z: f64,
    /// Angle of the column \[rad\].
    pub(crate) theta1: f64,
    /// Absolute angle of the wrist link \[rad\].
    pub(crate) theta4: f64,
    /// Roll of the wrist, q5 \[rad\].
    pub(crate) theta5: f64,
    /// Turn of the flange, q6 \[rad\].
    pub(crate) theta6: f64,
    /// Sine of theta4.
    pub(crate) s4: f64,
    /// Cosine of theta4.
    pub(crate) c4: f64,
}

impl Wrist {
    /// The solution with `sin q5 >= 0`; on the wrist singularity theta4 stays as in `near`.
    #[allow(non_snake_case)]
    pub(crate) fn of(X_BF: &Pose, side: Side, near: &Six) -> Result<Self, NoInverse> {
        let p = X_BF.translation.vector;
        let rho = p.x.hypot(p.y);
        if rho.is_nan() || rho < SHOULDER_SINGULAR {
            return Err(NoInverse::Singular { name: "shoulder" });
        }
        let (y, x, rho) = if side == Side::Front { (p.y, p.x, rho) } else { (-p.y, -p.x, -rho) };
        let (s1, c1) = (y / rho.abs(), x / rho.abs());
        let theta1 = y.atan2(x);
        let rotation = X_BF.rotation.to_rotation_matrix();
        let r = rotation.matrix();
        // In the vertical plane of the arm: forwards and sideways parts of the flange's axes.
        let forwards = |column: usize| c1 * r[(0, column)] + s1 * r[(1, column)];
        let s5s4 = forwards(2);
        let s5c4 = r[(2, 2)];
        let c5 = c1 * r[(1, 2)] - s1 * r[(0, 2)];
        let s5 = s5s4.hypot(s5c4);
        let (theta4, s4, c4, theta5) = if s5 < WRIST_SINGULAR {
            let theta4 = theta4_of(near);
            let (s4, c4) = theta4.sin_cos();
            (theta4, s4, c4, if c5 > 0.0 { 0.0 } else { PI })
        } else {
            (s5s4.atan2(s5c4), s5s4 / s5, s5c4 / s5, s5.atan2(c5))
        };
        // From the axis of V in the flange's frame: errors of theta4 and theta6 near the singularity then cancel in the pose.
        let along_v = |column: usize| c4 * forwards(column) - s4 * r[(2, column)];
        let theta6 = along_v(0).atan2(along_v(1));
        Ok(Self { rho, z: p.z, theta1, theta4, theta5, theta6, s4, c4 })
    }

    /// The other solution; on the singularity, where both are the same, this one.
    pub(crate) fn flipped(&self) -> Self {
        self.other().unwrap_or(*self)
    }

    /// The other solution, if there is one.
    pub(crate) fn other(&self) -> Option<Self> {
        if self.theta5 == 0.0 || self.theta5 == PI {
            return None;
        }
        Some(Self {
            theta4: self.theta4 + PI,
            theta5: -self.theta5,
            theta6: self.theta6 + PI,
            s4: -self.s4,
            c4: -self.c4,
            ..*self
        })
    }

    /// Sum of the squares by which the wrist angles differ from `near` \[rad²\].
    pub(crate) fn distance(&self, near: &Six) -> f64 {
        let square = |angle: f64, near: f64| (closest(angle, near) - near).powi(2);
        square(self.theta4, theta4_of(near)) + square(self.theta5, near[4]) + square(self.theta6, near[5])
    }
}

/// Absolute angle of the wrist link \[rad\].
fn theta4_of(q: &Six) -> f64 {
    q[1] + q[2] + q[3] + FRAC_PI_2
}
