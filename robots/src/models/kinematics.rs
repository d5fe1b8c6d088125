//! What the robots of this crate offer beyond [`Robot`]: Jacobians, all solutions, and how well a pose can be moved.
//!
//! In: joint positions, or a pose of the flange and the joint positions to stay near. Out: Jacobians, all
//! solutions of the inverse kinematics, and measures of dexterity (Yoshikawa 1985; Klein and Blaho 1987):
//!
//! ```text
//! (v, omega) = J(q) qdot,     manipulability = product of the singular values of J,
//! singularity distance = smallest singular value of diag(1/reach, 1) J
//! ```

use core::f64::consts::TAU;

use mrroc::prelude::*;
use mrroc::robot::{JointKind, JointVector, NoInverse};
use nalgebra::{SMatrix, SVector, Vector3};

use crate::models::singular::singular_values;

/// A geometric Jacobian: column `i` is what joint `i` alone does to the flange per unit of its speed. Rows 0 to 2: the
/// velocity of the flange's origin [m/s]; rows 3 to 5: its angular velocity [rad/s]; both along the world's axes.
pub type Jacobian<const N: usize> = SMatrix<f64, 6, N>;

/// Kinematics of a robot with `N` joints; nothing here allocates.
pub trait Kinematics<const N: usize>: Robot<Joints = SVector<f64, N>> {
    /// Largest distance of the flange from the first joint that turns it \[m\], > 0, about: lengths are divided by it where
    /// they are compared with angles.
    fn reach(&self) -> f64;

    /// The [`Jacobian`] at `q` [rad or m]: linear rows, then angular, in the world, at the flange's origin.
    fn jacobian(&self, q: &SVector<f64, N>) -> Jacobian<N>;

    /// Calls `visit` with every solution of the inverse kinematics, each once; every revolute joint is turned as near
    /// to `near` as full turns allow. Solutions may break limits: [`Kinematics::is_attainable`] tells.
    ///
    /// A robot with more joints than the pose needs has infinitely many: it visits one of each family and says which.
    ///
    /// # Errors
    /// [`NoInverse`] when there is none; then `visit` has not been called.
    #[allow(non_snake_case)]
    fn solutions(
        &self,
        X_WF: &Pose,
        near: &SVector<f64, N>,
        visit: &mut dyn FnMut(&SVector<f64, N>),
    ) -> Result<(), NoInverse>;

    /// Whether `q` [rad or m] keeps the joint limits and what joints share (motors, linkages).
    fn is_attainable(&self, q: &SVector<f64, N>) -> bool {
        let limits = self.limits();
        (0..N).all(|i| (limits.lower[i]..=limits.upper[i]).contains(&q[i]))
            && self.check_coupled(q, q, 1.0).is_ok()
    }

    /// The attainable solution nearest to `near` (least sum of squares of the joints' differences): every joint is
    /// first turned by full turns into its limits. `None` when there are solutions but none is attainable.
    ///
    /// For choosing a goal. [`Robot::inverse`] stays on the branch and the turn nearest to `near` whatever the limits
    /// are: a path then ends at the limit, with a fault that names it, and does not jump to another branch before.
    ///
    /// # Errors
    /// As [`Kinematics::solutions`].
    #[allow(non_snake_case)]
    fn nearest_attainable(
        &self,
        X_WF: &Pose,
        near: &SVector<f64, N>,
    ) -> Result<Option<SVector<f64, N>>, NoInverse> {
        let mut best: Option<(f64, SVector<f64, N>)> = None;
        self.attainable(X_WF, near, &mut |q| {
            let distance = (q - near).norm_squared();
            if best.is_none_or(|(least, _)| distance < least) {
                best = Some((distance, *q));
            }
        })?;
        Ok(best.map(|(_, q)| q))
    }

    /// Calls `visit` with every attainable solution, each joint turned by full turns into its limits, as near to `near` as these allow: goals of
    /// a planner, which may choose any.
    ///
    /// # Errors
    /// As [`Kinematics::solutions`].
    #[allow(non_snake_case)]
    fn attainable(
        &self,
        X_WF: &Pose,
        near: &SVector<f64, N>,
        visit: &mut dyn FnMut(&SVector<f64, N>),
    ) -> Result<(), NoInverse> {
        self.solutions(X_WF, near, &mut |q| {
            let q = turned_into_limits(self, q, near);
            if self.is_attainable(&q) {
                visit(&q);
            }
        })
    }

    /// Manipulability (Yoshikawa 1985) at `q`: the product of the Jacobian's singular values, `sqrt(det(J J^T))` with 6
    /// joints or more [m^3 where they are 6 turns]; 0 on a singularity.
    fn manipulability(&self, q: &SVector<f64, N>) -> f64 {
        singular_values(&self.jacobian(q), 1.0).iter().take(N.min(6)).product()
    }

    /// How far `q` is from the nearest singularity: the smallest singular value of the Jacobian with lengths divided by
    /// [`Kinematics::reach`], dimensionless; 0 on a singularity. It is the speed of the flange in its slowest direction when
    /// the joints turn at 1 rad/s together (root of the sum of squares).
    fn singularity_distance(&self, q: &SVector<f64, N>) -> f64 {
        let values = singular_values(&self.jacobian(q), self.reach());
        values.iter().take(N.min(6)).fold(f64::INFINITY, |least, value| least.min(*value))
    }
}

/// `q` with every revolute joint turned by full turns into its limits, as near to `near` as these allow.
fn turned_into_limits<const N: usize, R: Kinematics<N>>(
    robot: &R,
    q: &SVector<f64, N>,
    near: &SVector<f64, N>,
) -> SVector<f64, N> {
    let limits = robot.limits();
    JointVector::from_joints(|i| {
        let angle = closest(q[i], near[i]);
        match robot.joint(i) {
            JointKind::Prismatic => q[i],
            JointKind::Revolute if angle > limits.upper[i] => {
                angle - TAU * ((angle - limits.upper[i]) / TAU).ceil()
            }
            JointKind::Revolute if angle < limits.lower[i] => {
                angle + TAU * ((limits.lower[i] - angle) / TAU).ceil()
            }
            JointKind::Revolute => angle,
        }
    })
}

/// A column of a Jacobian from its linear and its angular part.
pub(crate) fn column(linear: &Vector3<f64>, angular: &Vector3<f64>) -> SVector<f64, 6> {
    SVector::<f64, 6>::new(linear.x, linear.y, linear.z, angular.x, angular.y, angular.z)
}

/// The displacement along x \[m\] of a pose that is a displacement along x, up to `off` \[m or rad\].
///
/// # Errors
/// [`NoInverse::NotAttainable`] with the distance from the x axis, or the turn, that exceeds `off`.
#[allow(non_snake_case)]
pub(crate) fn position_along_x(X_BF: &Pose, off: f64) -> Result<f64, NoInverse> {
    let p = X_BF.translation.vector;
    let aside = p.y.hypot(p.z);
    let turn = X_BF.rotation.angle();
    let refused = |what, actual, unit| Err(NoInverse::NotAttainable { what, actual, tolerance: off, unit });
    let on_line = p.x.is_finite() && aside <= off;
    if !on_line {
        refused("distance from the line of motion", aside, "m")
    } else if turn <= off {
        Ok(p.x)
    } else {
        refused("turn", turn, "rad")
    }
}

/// The angle equal to `angle` up to full turns that lies closest to `near` \[rad\].
#[inline]
pub(crate) fn closest(angle: f64, near: f64) -> f64 {
    // Adding 1.5 * 2^52 rounds to a whole number, without a call.
    const ROUNDER: f64 = 6_755_399_441_055_744.0;
    let turns = ((angle - near) * (1.0 / TAU) + ROUNDER) - ROUNDER;
    angle - TAU * turns
}

/// Sine and cosine of an angle from those of its half.
#[inline]
pub(crate) fn doubled((sine, cosine): (f64, f64)) -> (f64, f64) {
    (2.0 * sine * cosine, (cosine - sine) * (cosine + sine))
}

#[cfg(test)]
mod tests {
    use super::closest;
    use core::f64::consts::{PI, TAU};

    #[test]
    fn the_closest_turn_is_within_half_a_turn() {
        for k in -4_000..4_000 {
            let angle = f64::from(k) * 240.1;
            for near in [0.0, 2.9, -700.0, 6300.0] {
                let found = closest(angle, near);
                assert!((found - near).abs() < PI + 1e-9, "{angle} {near}");
                let turns = (found - angle) / TAU;
                assert!((turns - turns.round()).abs() < 1e-9, "{angle} {near}");
            }
        }
    }
}
