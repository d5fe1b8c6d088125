//! Cameras on hands and tips in closed form: fast enough to try many readings of the same numbers.
//!
//! In: poses `F_i` of a flange, and `B_i` of a board in the camera. With `X` the camera on the flange, `F_i X B_i` is the same for all, so that for two of them
//! `A X = X B` with `A = F_j^-1 F_i` and `B = B_j B_i^-1`. The rotation is the quaternion `x` for which `sum |a x - x b|^2` is least (Horaud and Dornaika 1995); then
//! `(R_A - 1) t_X = R_X s t_B - t_A` is linear, with the scale `s` of the board's lengths if that is to be found, too. Out: what is left of each pose.

use mrroc::pose::Pose;
use nalgebra::{DMatrix, DVector, Matrix4, Quaternion, UnitQuaternion, Vector3, Vector4};

/// What is left of a pose: a length \[m\] and an angle \[rad\].
pub(crate) type Left = [f64; 2];

/// With how many of the poses behind it a pose is compared: with all, as far as time allows.
const NEXT: usize = 16;

/// A camera on a flange, and where the board is.
#[derive(Clone, Copy, Debug)]
pub(crate) struct QuickEye {
    camera: Pose,
    board: Pose,
    /// By what lengths of the board are to be multiplied.
    pub(crate) scale: f64,
}

impl QuickEye {
    /// From some of the pairs; `None` if they tell none.
    pub(crate) fn of(pairs: &[(Pose, Pose)], is_scale_free: bool) -> Option<Self> {
        let mut normal = Matrix4::zeros();
        let n = pairs.len();
        let motions: Vec<(Pose, Pose)> = (0..n)
            .flat_map(|i| (1..n.min(NEXT)).map(move |k| (i, (i + k) % n)))
            .map(|(i, j)| (pairs[j].0.inv_mul(&pairs[i].0), pairs[j].1 * pairs[i].1.inverse()))
            .collect();
        for (a, b) in &motions {
            let difference = product_left(&a.rotation) - product_right(&b.rotation);
            // Near half a turn noise decides which of its two quaternions a rotation has: such a motion counts for nothing.
            normal += (a.rotation.w * b.rotation.w).abs() * difference.transpose() * difference;
        }
        let turn = least(&normal)?;
        let unknowns = if is_scale_free { 4 } else { 3 };
        let (mut square, mut right) = (DMatrix::zeros(unknowns, unknowns), DVector::zeros(unknowns));
        for (a, b) in &motions {
            let by_place = a.rotation.to_rotation_matrix().matrix() - nalgebra::Matrix3::identity();
            let board = turn * b.translation.vector;
            let mut rows = DMatrix::zeros(3, unknowns);
            rows.view_mut((0, 0), (3, 3)).copy_from(&by_place);
            let mut value = -a.translation.vector;
            if is_scale_free {
                rows.column_mut(3).copy_from(&-board);
            } else {
                value += board;
            }
            square += rows.transpose() * &rows;
            right += rows.transpose() * value;
        }
        let solution = square.pseudo_inverse(1e-9).ok()? * right;
        let scale = if is_scale_free { solution[3] } else { 1.0 };
        let at = Vector3::new(solution[0], solution[1], solution[2]);
        let camera = Pose::from_parts(at.into(), turn);
        let mut found = Self { camera, board: Pose::identity(), scale };
        let boards: Vec<Pose> = pairs.iter().map(|pair| found.board_of(pair)).collect();
        found.board = mean(&boards)?;
        (scale > 0.0 && scale.is_finite()).then_some(found)
    }

    fn board_of(&self, (flange, board): &(Pose, Pose)) -> Pose {
        let scaled = Pose::from_parts((self.scale * board.translation.vector).into(), board.rotation);
        flange * self.camera * scaled
    }

    /// What is left of a pair, and by what the board seems turned, in its own axes \[rad\].
    pub(crate) fn left(&self, pair: &(Pose, Pose)) -> (Left, Vector3<f64>) {
        let off = self.board.inv_mul(&self.board_of(pair));
        ([off.translation.vector.norm(), off.rotation.angle()], off.rotation.scaled_axis())
    }
}

/// What is left of the tip of a tool, by pose \[m\], with the tip and the point of the poses that are told by `of`.
pub(crate) fn quick_tip(flanges: &[Pose], of: &[usize]) -> Option<Vec<f64>> {
    let (mut square, mut right) = (DMatrix::zeros(6, 6), DVector::zeros(6));
    for i in of {
        let mut rows = DMatrix::zeros(3, 6);
        rows.view_mut((0, 0), (3, 3)).copy_from(flanges[*i].rotation.to_rotation_matrix().matrix());
        rows.view_mut((0, 3), (3, 3)).copy_from(&-nalgebra::Matrix3::identity());
        square += rows.transpose() * &rows;
        right -= rows.transpose() * flanges[*i].translation.vector;
    }
    let solution = square.pseudo_inverse(1e-9).ok()? * right;
    let (tip, point) = (solution.fixed_rows::<3>(0).into_owned(), solution.fixed_rows::<3>(3).into_owned());
    let left =
        |flange: &Pose| (flange.rotation * Vector3::from(tip) + flange.translation.vector - point).norm();
    Some(flanges.iter().map(left).collect())
}

/// The mean of positions, and of orientations.
fn mean(poses: &[Pose]) -> Option<Pose> {
    let places = poses.iter().map(|pose| pose.translation.vector).sum::<Vector3<f64>>() / poses.len() as f64;
    let mut squares = Matrix4::zeros();
    for pose in poses {
        let q = pose.rotation.quaternion();
        let q = Vector4::new(q.w, q.i, q.j, q.k);
        squares -= q * q.transpose();
    }
    Some(Pose::from_parts(places.into(), least(&squares)?))
}

/// The unit quaternion `q`, scalar first, for which `q^T M q` is least.
fn least(matrix: &Matrix4<f64>) -> Option<UnitQuaternion<f64>> {
    if !matrix.iter().all(|number| number.is_finite()) {
        return None;
    }
    let eigen = matrix.symmetric_eigen();
    let q = eigen.eigenvectors.column(eigen.eigenvalues.imin());
    Some(UnitQuaternion::new_normalize(Quaternion::new(q[0], q[1], q[2], q[3])))
}

/// `a x` as a matrix times x; of the two quaternions of a rotation the one that turns by less than half a turn.
fn product_left(a: &UnitQuaternion<f64>) -> Matrix4<f64> {
    let (w, x, y, z) = parts(a);
    Matrix4::new(w, -x, -y, -z, x, w, -z, y, y, z, w, -x, z, -y, x, w)
}

/// `x b` as a matrix times x.
fn product_right(b: &UnitQuaternion<f64>) -> Matrix4<f64> {
    let (w, x, y, z) = parts(b);
    Matrix4::new(w, -x, -y, -z, x, w, z, -y, y, -z, w, x, z, y, -x, w)
}

fn parts(q: &UnitQuaternion<f64>) -> (f64, f64, f64, f64) {
    let sign = if q.w < 0.0 { -1.0 } else { 1.0 };
    (sign * q.w, sign * q.i, sign * q.j, sign * q.k)
}
