//! What several arms do to a body besides moving it.
//!
//! In: the wrenches `F_i` at the tools' frames E_i, each the load of the body *on the tool*, as a wrist sensor reads it.
//! Out: their external part, which adds up to the load of the body, and their internal part, which adds up to nothing
//! and only strains the body. With `G_i` the 6 x 6 matrix that moves a wrench from E_i to B, `G = [G_1 .. G_n]` (the
//! grasp matrix):
//!
//! ```text
//! load         F_B   = sum_i G_i F_i
//! external     F_i^x = G_i^+ F_B,      sum_i G_i G_i^+ = 1
//! internal     F_i^n = F_i - F_i^x,    sum_i G_i F_i^n = 0
//! ```
//!
//! Which part is internal is decided by the weights of the generalised inverse `G^+`, that is, by how the load is
//! shared:
//!
//! - [`Sharing::elastic`]: `G_i^+ = K_i G_i^T (sum_j G_j K_j G_j^T)^-1`, the shares that grasps of stiffness `K_i` take
//!   when nothing is misplaced (least elastic energy). The internal part is then exactly the stress of misplaced grasps;
//! - [`Sharing::nonsqueezing`]: `G_i^+ = a_i G_i^-1`, shares `a_i` of the load moved to each tool (Walker, Freeman and
//!   Marcus, IJRR 10(4), 1991; for two arms with `a_i = 1/2` Uchiyama and Dauchez's virtual sticks, ICRA 1988: `(F_1 -
//!   F_2) / 2` at B). The bending moment of the body under its own weight then counts as internal.
//!
//! Erhart and Hirche (IEEE T-RO 31(5), 2015) compare such choices.

use mrroc::pose::{Pose, Wrench};
use nalgebra::{Matrix3, Matrix6, Vector3, Vector6};

/// Stiffness of a grasp at the tool's origin, the same in all directions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GraspStiffness {
    /// Of displacement [N/m], finite, > 0.
    pub force: f64,
    /// Of turning [N m/rad], finite, > 0.
    pub torque: f64,
}

/// The share that one arm takes of the body's load.
#[derive(Clone, Copy, Debug, PartialEq)]
#[allow(non_snake_case)]
pub struct Sharing {
    X_BE: Pose,
    /// `G_i^+`.
    share: Matrix6<f64>,
}

/// `G`: the matrix that moves a wrench (force, torque) from E to B.
#[allow(non_snake_case)]
fn grasp_matrix(X_BE: &Pose) -> Matrix6<f64> {
    let R: Matrix3<f64> = X_BE.rotation.to_rotation_matrix().into_inner();
    let mut G = Matrix6::zeros();
    G.fixed_view_mut::<3, 3>(0, 0).copy_from(&R);
    G.fixed_view_mut::<3, 3>(3, 3).copy_from(&R);
    G.fixed_view_mut::<3, 3>(3, 0).copy_from(&(X_BE.translation.vector.cross_matrix() * R));
    G
}

#[allow(non_snake_case)]
impl Sharing {
    /// The share of arm `i` of those that hold the body at `X_BE`, by grasps of the same stiffness; grasps without any
    /// take no share.
    ///
    /// # Panics
    /// When there is no arm `i`.
    #[must_use]
    pub fn elastic(X_BE: &[Pose], i: usize, stiffness: GraspStiffness) -> Self {
        let GraspStiffness { force: f, torque: t } = stiffness;
        let K = Matrix6::from_diagonal(&Vector6::new(f, f, f, t, t, t));
        let whole = X_BE.iter().fold(Matrix6::zeros(), |sum, pose| {
            let G = grasp_matrix(pose);
            sum + G * K * G.transpose()
        });
        let compliance = whole.try_inverse().unwrap_or_else(Matrix6::zeros);
        Sharing { X_BE: X_BE[i], share: K * grasp_matrix(&X_BE[i]).transpose() * compliance }
    }

    /// A share `a` of the load, 0 to 1, moved to the tool at `X_BE`; the shares of all arms add up to 1.
    #[must_use]
    pub fn nonsqueezing(X_BE: Pose, share: f64) -> Self {
        Sharing { X_BE, share: grasp_matrix(&X_BE.inverse()) * share }
    }
}

/// The split of the wrenches of all arms, in the order of the list of robots. `A` is an array of shares:
/// `[Sharing; 2]`, or `L::Each<Sharing>` of any list.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InternalForce<A> {
    arms: A,
}

#[allow(non_snake_case)]
impl<A: AsRef<[Sharing]>> InternalForce<A> {
    /// The split by these shares.
    #[must_use]
    pub const fn new(arms: A) -> Self {
        InternalForce { arms }
    }

    /// The load of the body at B of the wrenches at the tools \[N, N m\].
    #[must_use]
    pub fn load(&self, F_E: &[Wrench]) -> Wrench {
        let arms = self.arms.as_ref().iter().zip(F_E);
        arms.fold(Wrench::default(), |sum, (arm, wrench)| sum + wrench.moved(&arm.X_BE))
    }

    /// Takes the external part from every wrench, each at its tool: the internal part remains. Returns the load.
    pub fn keep_internal(&self, F_E: &mut [Wrench]) -> Wrench {
        let load = self.load(F_E);
        for (arm, wrench) in self.arms.as_ref().iter().zip(F_E) {
            *wrench = *wrench - arm.external(&load);
        }
        load
    }
}

impl Sharing {
    /// The external part at the tool of a load at B.
    #[must_use]
    pub fn external(&self, load: &Wrench) -> Wrench {
        let f = &load.force;
        let t = &load.torque;
        let part = self.share * Vector6::new(f.x, f.y, f.z, t.x, t.y, t.z);
        Wrench::new(part.fixed_rows::<3>(0).into(), part.fixed_rows::<3>(3).into())
    }
}

/// The load on tool `i` \[N\] when all arms press towards the middle `c` of their grasps with forces in proportion to their
/// distance from it, `force` \[N\] on the mean: `F (p_i - c) / mean |p_j - c|`. It adds up to nothing, force and torque; two
/// arms press with `force` along the line between them. A negative force pulls.
///
/// # Panics
/// When there is no arm `i`.
#[must_use]
#[allow(non_snake_case)]
pub fn central_squeeze(X_BE: &[Pose], i: usize, force: f64) -> Wrench {
    let arms = X_BE.len().max(1) as f64;
    let middle = X_BE.iter().map(|pose| pose.translation.vector).sum::<Vector3<f64>>() / arms;
    let mean = X_BE.iter().map(|pose| (pose.translation.vector - middle).norm()).sum::<f64>() / arms;
    let outwards = X_BE[i].translation.vector - middle;
    // Tools at one point have no direction to press in.
    let force = if mean > 0.0 { outwards * (force / mean) } else { Vector3::zeros() };
    Wrench::new(X_BE[i].rotation.inverse() * force, Vector3::zeros())
}

#[cfg(test)]
#[allow(non_snake_case)]
mod tests {
    use super::*;
    use nalgebra::{DMatrix, DVector};
    use proptest::prelude::*;

    const K: GraspStiffness = GraspStiffness { force: 5e4, torque: 500.0 };

    fn poses() -> impl Strategy<Value = Pose> {
        proptest::array::uniform6(-1.0..1.0f64)
            .prop_map(|x| Pose::new(Vector3::new(x[0], x[1], x[2]), Vector3::new(x[3], x[4], x[5]) * 3.0))
    }

    fn wrenches() -> impl Strategy<Value = Wrench> {
        proptest::array::uniform6(-50.0..50.0f64)
            .prop_map(|x| Wrench::new(Vector3::new(x[0], x[1], x[2]), Vector3::new(x[3], x[4], x[5]) * 0.1))
    }

    fn size(wrench: &Wrench) -> f64 {
        wrench.force.norm() + wrench.torque.norm()
    }

    fn vector(wrenches: &[Wrench]) -> DVector<f64> {
        let numbers = wrenches.iter().flat_map(|w| w.force.iter().chain(w.torque.iter()).copied());
        DVector::from_iterator(6 * wrenches.len(), numbers)
    }

    /// The internal part by another method: the external one is the `x` of least elastic energy `x^T K^-1 x / 2` with `G x` the
    /// load, from the equations of Lagrange's multipliers.
    fn reference(X_BE: &[Pose], F: &[Wrench]) -> DVector<f64> {
        let n = X_BE.len();
        let mut G = DMatrix::zeros(6, 6 * n);
        for (i, pose) in X_BE.iter().enumerate() {
            for column in 0..6 {
                let unit = |from| Vector3::from_fn(|row, _| f64::from(from + row == column));
                let moved = vector(&[Wrench::new(unit(0), unit(3)).moved(pose)]);
                G.set_column(6 * i + column, &moved);
            }
        }
        let F = vector(F);
        let mut equations = DMatrix::zeros(6 * n + 6, 6 * n + 6);
        for row in 0..6 * n {
            equations[(row, row)] = if row % 6 < 3 { 1.0 } else { K.force / K.torque };
        }
        equations.view_mut((0, 6 * n), (6 * n, 6)).copy_from(&G.transpose());
        equations.view_mut((6 * n, 0), (6, 6 * n)).copy_from(&G);
        let mut right = DVector::zeros(6 * n + 6);
        right.rows_mut(6 * n, 6).copy_from(&(G * &F));
        let solution = equations.full_piv_lu().solve(&right).expect("grasps with a load");
        F - solution.rows(0, 6 * n)
    }

    proptest! {
        #[test]
        fn internal_wrenches_add_up_to_nothing_and_are_those_of_the_weighted_pseudo_inverse(
            X_BE in proptest::collection::vec(poses(), 2..6), F in proptest::array::uniform5(wrenches()),
        ) {
            let mut internal = F[..X_BE.len()].to_vec();
            let arms: Vec<_> = (0..X_BE.len()).map(|i| Sharing::elastic(&X_BE, i, K)).collect();
            let split = InternalForce::new(arms);
            let load = split.keep_internal(&mut internal);
            let expected = reference(&X_BE, &F[..X_BE.len()]);
            prop_assert!(size(&split.load(&internal)) < 1e-9);
            let error = (vector(&internal) - expected).amax();
            prop_assert!(error < 1e-8, "{}", error);
            prop_assert_eq!(load, split.load(&F[..X_BE.len()]));
        }

        #[test]
        fn two_arms_of_equal_shares_are_virtual_sticks(X_BE in proptest::array::uniform2(poses()), F in proptest::array::uniform2(wrenches())) {
            let split = InternalForce::new(X_BE.map(|pose| Sharing::nonsqueezing(pose, 0.5)));
            let mut internal = F;
            split.keep_internal(&mut internal);
            let relative = (F[0].moved(&X_BE[0]) - F[1].moved(&X_BE[1])) * 0.5;
            prop_assert!(size(&(internal[0].moved(&X_BE[0]) - relative)) < 1e-12 * 100.0);
            prop_assert!(size(&(internal[1].moved(&X_BE[1]) + relative)) < 1e-12 * 100.0);
        }

        #[test]
        fn a_squeeze_is_internal(X_BE in proptest::array::uniform4(poses())) {
            let squeeze: [_; 4] = core::array::from_fn(|i| central_squeeze(&X_BE, i, 30.0));
            let mut internal = squeeze;
            InternalForce::new(core::array::from_fn::<_, 4, _>(|i| Sharing::elastic(&X_BE, i, K)))
                .keep_internal(&mut internal);
            for (kept, squeeze) in internal.iter().zip(&squeeze) {
                prop_assert!(size(&(*kept - *squeeze)) < 1e-9);
            }
        }
    }

    #[test]
    fn grasps_that_only_carry_a_weight_are_not_stressed() {
        // A bar of 0.4 m with 30 N at its middle, held level at its ends: 15 N each, and no torque is internal.
        let X_BE = [Pose::translation(-0.2, 0.0, 0.0), Pose::translation(0.2, 0.0, 0.0)];
        let half = Wrench::new(Vector3::new(0.0, 0.0, -15.0), Vector3::zeros());
        let mut internal = [half, half];
        let load =
            InternalForce::new([0, 1].map(|i| Sharing::elastic(&X_BE, i, K))).keep_internal(&mut internal);
        assert!((load.force.z + 30.0).abs() < 1e-12 && internal.iter().all(|wrench| size(wrench) < 1e-12));
        // The virtual sticks count the bar's bending moment of 3 N m.
        let mut internal = [half, half];
        InternalForce::new(X_BE.map(|pose| Sharing::nonsqueezing(pose, 0.5))).keep_internal(&mut internal);
        assert!((internal[0].torque.y.abs() - 3.0).abs() < 1e-12);
    }

    #[test]
    fn the_internal_part_is_the_stress_of_misplaced_grasps() {
        // Two springs in a row on a bar: 1 mm too close makes f = k d / 2, pressing both tools outwards.
        let X_BE = [Pose::translation(-0.2, 0.0, 0.0), Pose::translation(0.2, 0.0, 0.0)];
        let press = Vector3::new(25.0, 0.0, 0.0);
        let weight = Vector3::new(0.0, 0.0, -15.0);
        let mut wrenches =
            [Wrench::new(weight - press, Vector3::zeros()), Wrench::new(weight + press, Vector3::zeros())];
        InternalForce::new([0, 1].map(|i| Sharing::elastic(&X_BE, i, K))).keep_internal(&mut wrenches);
        assert!((wrenches[0].force + press).norm() < 1e-12 && (wrenches[1].force - press).norm() < 1e-12);
        assert!((central_squeeze(&X_BE, 1, 25.0).force - press).norm() < 1e-12);
    }
}
