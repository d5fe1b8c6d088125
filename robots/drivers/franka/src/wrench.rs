//! The wrench that the robot estimates, at its flange.
//!
//! In: the robot's estimate `K_F_ext_hat_K`, which is at its stiffness frame K, and the poses of K and of its end effector EE.
//! Out: `F_F`, the wrench of the surroundings on the flange F.
//!
//! ```text
//! F_F = - X_FK K_F_ext_hat_K,    X_FK = F_T_EE EE_T_K
//! ```
//!
//! The sign: libfranka's `robot_state.h` counts forces of the robot on its surroundings as positive.

use mrroc::pose::{Pose, Wrench};
use nalgebra::{Matrix3, Rotation3, Translation3, UnitQuaternion, Vector3};

/// How far a matrix of the robot may be from a rotation: libfranka refuses frames that are off by 1e-5 when it is told them, and
/// the robot tells them with 24 bits.
const OFF: f64 = 1e-4;

/// What the robot says of the wrench that acts on it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[allow(non_snake_case)]
pub struct External {
    /// The end effector in the flange frame, a matrix by columns \[m\].
    pub F_T_EE: [f64; 16],
    /// The stiffness frame in that of the end effector, a matrix by columns \[m\].
    pub EE_T_K: [f64; 16],
    /// The estimate: force \[N\] and torque [N m] of the robot on its surroundings, at the origin of the stiffness frame and in
    /// its axes, without the weight of what the robot was told to carry. All are 0 near a singularity.
    pub K_F_ext_hat_K: [f64; 6],
}

impl External {
    /// `F_F`: of the surroundings on the flange, at its origin and in its axes. `None` if a number is none, or a matrix is no
    /// pose.
    #[must_use]
    #[allow(non_snake_case)]
    pub fn wrench(&self) -> Option<Wrench> {
        let X_FK = pose(&self.F_T_EE)? * pose(&self.EE_T_K)?;
        let [fx, fy, fz, tx, ty, tz] = self.K_F_ext_hat_K;
        let of_robot = Wrench::new(Vector3::new(fx, fy, fz), Vector3::new(tx, ty, tz));
        Some(-of_robot.moved(&X_FK)).filter(Wrench::is_finite)
    }
}

/// The pose that is a matrix by columns; `None` if it is none.
fn pose(columns: &[f64; 16]) -> Option<Pose> {
    let [a, b, c, g, d, e, f, h, i, j, k, l, x, y, z, one] = *columns;
    #[rustfmt::skip]
    let rotation = Matrix3::new(
        a, d, i,
        b, e, j,
        c, f, k,
    );
    let off = (rotation.transpose() * rotation - Matrix3::identity()).amax();
    let below = [g, h, l, one - 1.0].into_iter().map(f64::abs).fold(0.0, f64::max);
    // Written so that what is no number is no pose, either.
    let is_pose = off <= OFF
        && below <= OFF
        && rotation.determinant() > 0.0
        && [x, y, z, g, h, l, one].iter().all(|number| number.is_finite());
    is_pose.then(|| {
        let turned = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(rotation));
        Pose::from_parts(Translation3::new(x, y, z), UnitQuaternion::new_normalize(turned.into_inner()))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const IDENTITY: [f64; 16] =
        [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0];

    /// A force \[N\] and a torque [N m].
    fn wrench(force: [f64; 3], torque: [f64; 3]) -> Wrench {
        Wrench::new(force.into(), torque.into())
    }

    fn is(told: &External, expected: Wrench) {
        let off = told.wrench().expect("a wrench") - expected;
        assert!(off.force.norm() < 1e-12 && off.torque.norm() < 1e-12, "{told:?}: {off:?}");
    }

    #[test]
    fn what_the_robot_pushes_pushes_back_on_its_flange() {
        // The robot pushes by 5 N along x, and turns by 0.5 N m about z: the surroundings do the contrary.
        let told =
            External { F_T_EE: IDENTITY, EE_T_K: IDENTITY, K_F_ext_hat_K: [5.0, 0.0, 0.0, 0.0, 0.0, 0.5] };
        is(&told, wrench([-5.0, 0.0, 0.0], [0.0, 0.0, -0.5]));
        let told = External { K_F_ext_hat_K: [-5.0, 0.0, 0.0, 0.0, 0.0, -0.5], ..told };
        is(&told, wrench([5.0, 0.0, 0.0], [0.0, 0.0, 0.5]));
        // Near a singularity it estimates nothing.
        is(&External { K_F_ext_hat_K: [0.0; 6], ..told }, Wrench::default());
    }

    #[test]
    fn a_force_at_the_end_effector_has_its_arm_at_the_flange() {
        // K is 0.1 m before the flange and turned by a right angle about z: its x is y of the flange. The surroundings push by
        // 10 N along x of K, which turns the flange by p x f = (0, 0, 0.1) x (0, 10, 0) = (-1, 0, 0).
        let quarter = [0.0, 1.0, 0.0, 0.0, -1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.04, 1.0];
        let further = [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.06, 1.0];
        let told =
            External { F_T_EE: quarter, EE_T_K: further, K_F_ext_hat_K: [-10.0, 0.0, 0.0, 0.0, 0.0, 0.0] };
        is(&told, wrench([0.0, 10.0, 0.0], [-1.0, 0.0, 0.0]));
        // The order of the two poses: EE 0.05 m along x, K turned there and 0.02 m along its own x, which is EE's y. A torque
        // about K's y is one about -x; a force along K's z of 2 N acts at (0.05, 0.02, 0): p x f = (0.04, -0.1, 0).
        let aside = [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.05, 0.0, 0.0, 1.0];
        let turned = [0.0, 1.0, 0.0, 0.0, -1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.02, 0.0, 1.0];
        let told =
            External { F_T_EE: aside, EE_T_K: turned, K_F_ext_hat_K: [0.0, 0.0, -2.0, 0.0, -0.3, 0.0] };
        is(&told, wrench([0.0, 0.0, 2.0], [0.04 - 0.3, -0.1, 0.0]));
    }

    #[test]
    #[allow(non_snake_case)]
    fn the_robot_does_the_same_work_at_its_flange_and_at_its_stiffness_frame_on_every_twist() {
        let X_FE = Pose::from_parts(
            Translation3::new(0.01, -0.03, 0.1034),
            UnitQuaternion::from_euler_angles(0.3, -0.2, -0.785),
        );
        let X_EK = Pose::from_parts(
            Translation3::new(-0.02, 0.05, 0.07),
            UnitQuaternion::from_euler_angles(-1.0, 0.4, 2.0),
        );
        let columns = |pose: &Pose| <[f64; 16]>::try_from(pose.to_homogeneous().as_slice()).expect("sixteen");
        let K_F = [3.0, -7.0, 11.0, 0.2, 0.5, -0.9];
        let told = External { F_T_EE: columns(&X_FE), EE_T_K: columns(&X_EK), K_F_ext_hat_K: K_F };
        let at_flange = told.wrench().expect("a wrench");
        // With the rotation and the origin of K by hand.
        let R = X_FE.rotation.to_rotation_matrix().matrix() * X_EK.rotation.to_rotation_matrix().matrix();
        let p =
            X_FE.translation.vector + X_FE.rotation.to_rotation_matrix().matrix() * X_EK.translation.vector;
        for i in 0..6 {
            let unit = |from| Vector3::from_fn(|j, _| if i == from + j { 1.0 } else { 0.0 });
            let (v, w): (Vector3<f64>, Vector3<f64>) = (unit(0), unit(3));
            let (v_K, w_K) = (R.transpose() * (v + w.cross(&p)), R.transpose() * w);
            let of_robot = Vector3::new(K_F[0], K_F[1], K_F[2]).dot(&v_K)
                + Vector3::new(K_F[3], K_F[4], K_F[5]).dot(&w_K);
            let on_flange = at_flange.force.dot(&v) + at_flange.torque.dot(&w);
            assert!((on_flange + of_robot).abs() < 1e-13, "{i}: {on_flange}, {of_robot}");
        }
    }

    #[test]
    fn what_is_no_number_or_no_pose_is_no_wrench() {
        let told = External { F_T_EE: IDENTITY, EE_T_K: IDENTITY, K_F_ext_hat_K: [1.0; 6] };
        assert!(told.wrench().is_some());
        for i in 0..6 {
            for bad in [f64::NAN, f64::INFINITY] {
                let mut broken = told;
                broken.K_F_ext_hat_K[i] = bad;
                assert_eq!(broken.wrench(), None, "{i}");
            }
        }
        for i in 0..16 {
            for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
                let (mut first, mut second) = (told, told);
                first.F_T_EE[i] = bad;
                second.EE_T_K[i] = bad;
                assert_eq!((first.wrench(), second.wrench()), (None, None), "{i}: {bad}");
            }
        }
        let mut mirror = IDENTITY;
        mirror[10] = -1.0;
        let mut longer = IDENTITY;
        longer[0] = 1.001;
        let mut projective = IDENTITY;
        projective[3] = 0.01;
        for matrix in [[0.0; 16], mirror, longer, projective] {
            assert_eq!(External { F_T_EE: matrix, ..told }.wrench(), None, "{matrix:?}");
        }
        // With the digits of a 24 bit number it is a rotation.
        let mut rounded = IDENTITY;
        (rounded[0], rounded[1]) = (f64::from(0.6_f32), f64::from(0.8_f32));
        (rounded[4], rounded[5]) = (f64::from(-0.8_f32), f64::from(0.6_f32));
        assert!(External { EE_T_K: rounded, ..told }.wrench().is_some());
    }
}
