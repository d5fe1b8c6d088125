//! Internal forces: the part of the grippers' forces on a body that neither carries nor moves it.
//!
//! The wrenches `w_i = (f_i, tau_i)` that grippers at `r_i` exert add up to `f = sum f_i`, `tau = sum tau_i + r_i x f_i`
//! (the grasp matrix W times all wrenches). The part of them that moves the body is taken as the one with the least
//! `sum |f_i|^2 + |tau_i|^2 / l^2`, the solution that a body of equal point masses at the grasps would move by (Erhart and
//! Hirche, Internal force analysis and load distribution for cooperative multi-robot manipulation, IEEE T-RO 31(5), 2015),
//! with l the mean distance of the grasps from their centre (root of the mean square):
//!
//! ```text
//! f_i = f / N + b x r_i,   tau_i = l^2 b,   (N l^2 + sum (|r_i|^2 - r_i r_i^T)) b = tau          r_i, tau about the centre
//! ```
//!
//! What is left lies in the null space of W: the internal wrenches, which add up to nothing.

use mrroc::pose::Wrench;
use nalgebra::{Matrix3, Vector3};

/// How N grippers share the total wrench on a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sharing {
    centre: Vector3<f64>,
    /// Force on each \[N\].
    force: Vector3<f64>,
    /// The vector b above [N/m].
    turn: Vector3<f64>,
    /// l^2 \[m²\].
    square: f64,
}

impl Sharing {
    /// The sharing of these wrenches on a body, each given with the place \[m\] at which it acts, all along the same axes.
    /// Grippers that are all in one place share torques evenly.
    #[must_use]
    pub fn of(grasps: impl Iterator<Item = (Vector3<f64>, Wrench)> + Clone) -> Self {
        let mut count = 0.0;
        let mut centre = Vector3::zeros();
        let mut force = Vector3::zeros();
        for (at, wrench) in grasps.clone() {
            count += 1.0;
            centre += at;
            force += wrench.force;
        }
        let count = f64::max(count, 1.0);
        centre /= count;
        let mut torque = Vector3::zeros();
        let mut levers = Matrix3::zeros();
        let mut square = 0.0;
        for (at, wrench) in grasps {
            let r = at - centre;
            torque += wrench.torque + r.cross(&wrench.force);
            square += r.norm_squared() / count;
            levers += Matrix3::identity() * r.norm_squared() - r * r.transpose();
        }
        // In one place no lever carries torque, and any l gives even shares.
        let square = if square > 0.0 { square } else { 1.0 };
        let matrix = Matrix3::identity() * (count * square) + levers;
        let turn = matrix.cholesky().map_or(Vector3::zeros(), |matrix| matrix.solve(&torque));
        Self { centre, force: force / count, turn, square }
    }

    /// The share of a gripper at `at` \[m\] in carrying and moving the body: a wrench at that place.
    #[must_use]
    pub fn share(&self, at: &Vector3<f64>) -> Wrench {
        Wrench::new(self.force + self.turn.cross(&(at - self.centre)), self.turn * self.square)
    }

    /// The internal part of one of the wrenches.
    #[must_use]
    pub fn internal(&self, (at, wrench): &(Vector3<f64>, Wrench)) -> Wrench {
        *wrench - self.share(at)
    }
}
