//! Direct kinematics of a chain, joint by joint, and its Jacobian.
//!
//! All joints at 0, the chain is described in one frame A: points on the axes, their directions, the tip. What a joint
//! turns is then all that follows, seen in A:
//!
//! ```text
//! R_i = R_i-1 exp(axis_i angle_i),   p_i+1 = p_i + R_i d_i      (of a slide: p_i + R_i-1 axis_i shift_i + ..)
//! ```
//!
//! A lies along the axes: of nearly all machines the axes then are x, y and z, and a turn about one of these mixes two
//! columns only.

use mrroc::pose::Pose;
use mrroc::robot::JointKind;
use nalgebra::{Quaternion, Rotation3, SMatrix, SVector, Translation3, UnitQuaternion, Vector3};

use super::chain::Segment;
use super::places::MOST_SEGMENTS;
use crate::models::kinematics::doubled;
use crate::models::sines::sin_cos;

/// How far an axis may be from x, y or z to be taken for it: round-off.
const ROUND_OFF: f64 = 1e-14;

/// Where an axis lies in the world: its direction, and a point on it \[m\].
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Axis {
    pub(super) direction: Vector3<f64>,
    pub(super) point: Vector3<f64>,
}

/// Direction of an axis in A.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Direction {
    X,
    Y,
    Z,
    Skew(Vector3<f64>),
}

/// One joint.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Step {
    kind: JointKind,
    direction: Direction,
    /// The coordinate that moves it: `multiplier q[leader] + offset`, about the direction given.
    leader: usize,
    multiplier: f64,
    offset: f64,
    /// From this axis to the next, or to the tip, in A with all joints at 0 \[m\].
    link: Vector3<f64>,
}

/// A chain, ready to be moved.
#[derive(Clone, Debug, PartialEq)]
#[allow(non_snake_case)]
pub(super) struct Linkage {
    steps: Vec<Step>,
    /// Orientation of A in the world, as rotation matrix and quaternion.
    R_WA: UnitQuaternion<f64>,
    columns: [Vector3<f64>; 3],
    /// A point on the first axis \[m\].
    start: Vector3<f64>,
    /// Orientation of the tip in A with all joints at 0.
    R_AF: UnitQuaternion<f64>,
}

/// Axes of a chain with all joints at 0, and the pose of the tip, in the world.
#[allow(non_snake_case)]
pub(super) fn at_zero(segments: &[Segment], X_tip: &Pose) -> (Vec<Axis>, Pose) {
    let mut pose = Pose::identity();
    let axes = segments.iter().map(|segment| {
        pose *= segment.X_before;
        Axis { direction: pose.rotation * Vector3::z(), point: pose.translation.vector }
    });
    let axes = axes.collect();
    (axes, pose * X_tip)
}

impl Linkage {
    /// The chain of these segments.
    #[allow(non_snake_case)]
    pub(super) fn new(segments: &[Segment], X_tip: &Pose) -> Self {
        let (axes, X_WF) = at_zero(segments, X_tip);
        let R_WA = along(&axes);
        let R_AW = R_WA.inverse();
        let ends = axes.iter().skip(1).map(|axis| axis.point).chain([X_WF.translation.vector]);
        let steps = segments.iter().zip(&axes).zip(ends).map(|((segment, axis), end)| {
            let (direction, sign) = named(R_AW * axis.direction);
            Step {
                kind: segment.kind,
                direction,
                leader: segment.leader,
                multiplier: sign * segment.multiplier,
                offset: sign * segment.offset,
                link: R_AW * (end - axis.point),
            }
        });
        Self {
            steps: steps.take(MOST_SEGMENTS).collect(),
            R_WA,
            columns: [Vector3::x(), Vector3::y(), Vector3::z()].map(|column| R_WA * column),
            start: axes.first().map_or_else(Vector3::zeros, |axis| axis.point),
            R_AF: R_AW * X_WF.rotation,
        }
    }

    /// Pose of the tip at `q` [rad or m] of the chain with these steps, at most `M`; `visit` is given each step with its
    /// axis.
    #[inline(always)]
    fn travel<const N: usize, const M: usize>(
        &self,
        steps: &[Step],
        q: &SVector<f64, N>,
        mut visit: impl FnMut(usize, &Step, Axis),
    ) -> Pose {
        let mut values = [0.0; M];
        let mut halves = [0.0; M];
        for (i, step) in steps.iter().enumerate().take(M) {
            values[i] = step.multiplier * q[step.leader] + step.offset;
            halves[i] = 0.5 * values[i];
        }
        let halves = sin_cos(halves);
        let mut point = self.start;
        let mut rotation = self.R_WA.into_inner();
        let mut columns = self.columns;
        for (i, step) in steps.iter().enumerate().take(M) {
            let [x, y, z] = columns;
            let direction = match &step.direction {
                Direction::X => x,
                Direction::Y => y,
                Direction::Z => z,
                Direction::Skew(axis) => x * axis.x + y * axis.y + z * axis.z,
            };
            visit(i, step, Axis { direction, point });
            match step.kind {
                JointKind::Prismatic => point += direction * values[i],
                JointKind::Revolute => {
                    let (s, c) = halves[i];
                    let (sine, cosine) = doubled((s, c));
                    let Quaternion { coords: r } = rotation;
                    let (i, j, k, w) = (r.x, r.y, r.z, r.w);
                    match &step.direction {
                        Direction::X => {
                            columns = [x, y * cosine + z * sine, z * cosine - y * sine];
                            rotation =
                                Quaternion::new(w * c - i * s, i * c + w * s, j * c + k * s, k * c - j * s);
                        }
                        Direction::Y => {
                            columns = [x * cosine - z * sine, y, z * cosine + x * sine];
                            rotation =
                                Quaternion::new(w * c - j * s, i * c - k * s, j * c + w * s, k * c + i * s);
                        }
                        Direction::Z => {
                            columns = [x * cosine + y * sine, y * cosine - x * sine, z];
                            rotation =
                                Quaternion::new(w * c - k * s, i * c + j * s, j * c - i * s, k * c + w * s);
                        }
                        Direction::Skew(axis) => {
                            rotation *= Quaternion::from_parts(c, axis * s);
                            columns = columns_of(&rotation);
                        }
                    }
                }
            }
            let [x, y, z] = columns;
            point += x * step.link.x + y * step.link.y + z * step.link.z;
        }
        let rotation = UnitQuaternion::new_unchecked(rotation * self.R_AF.into_inner());
        Pose::from_parts(Translation3::from(point), rotation)
    }

    /// Pose of the tip at `q` [rad or m].
    pub(super) fn forward<const N: usize>(&self, q: &SVector<f64, N>) -> Pose {
        match self.each_its_own::<N>() {
            Some(steps) => self.travel::<N, N>(steps, q, |_, _, _| {}),
            None => self.travel::<N, MOST_SEGMENTS>(&self.steps, q, |_, _, _| {}),
        }
    }

    /// Pose of the tip and geometric Jacobian at `q`: per coordinate the velocity of the tip's origin (rows 0 to 2), then
    /// its angular velocity (rows 3 to 5), both in the world. A joint that follows adds to its leader's column.
    pub(super) fn jacobian<const N: usize>(&self, q: &SVector<f64, N>) -> (Pose, SMatrix<f64, 6, N>) {
        match self.each_its_own::<N>() {
            Some(steps) => self.jacobian_of::<N, N>(steps, q),
            None => self.jacobian_of::<N, MOST_SEGMENTS>(&self.steps, q),
        }
    }

    #[inline(always)]
    fn jacobian_of<const N: usize, const M: usize>(
        &self,
        steps: &[Step],
        q: &SVector<f64, N>,
    ) -> (Pose, SMatrix<f64, 6, N>) {
        let mut axes = [Axis { direction: Vector3::zeros(), point: Vector3::zeros() }; M];
        let pose = self.travel::<N, M>(steps, q, |i, _, axis| axes[i] = axis);
        let mut jacobian = SMatrix::<f64, 6, N>::zeros();
        for (step, axis) in steps.iter().zip(&axes) {
            let direction = axis.direction * step.multiplier;
            let (linear, angular) = match step.kind {
                JointKind::Revolute => (direction.cross(&(pose.translation.vector - axis.point)), direction),
                JointKind::Prismatic => (direction, Vector3::zeros()),
            };
            let mut column = jacobian.column_mut(step.leader);
            for i in 0..3 {
                column[i] += linear[i];
                column[i + 3] += angular[i];
            }
        }
        (pose, jacobian)
    }

    /// The steps of a chain in which nothing follows: then their number is known to the compiler.
    #[inline(always)]
    fn each_its_own<const N: usize>(&self) -> Option<&[Step; N]> {
        <&[Step; N]>::try_from(self.steps.as_slice()).ok()
    }
}

/// The columns of the rotation matrix of a quaternion of length 1.
#[inline(always)]
fn columns_of(rotation: &Quaternion<f64>) -> [Vector3<f64>; 3] {
    let i = rotation.i;
    let j = rotation.j;
    let k = rotation.k;
    let w = rotation.w;
    let (i2, j2, k2) = (2.0 * i, 2.0 * j, 2.0 * k);
    [
        Vector3::new(1.0 - j2 * j - k2 * k, i2 * j + k2 * w, i2 * k - j2 * w),
        Vector3::new(i2 * j - k2 * w, 1.0 - i2 * i - k2 * k, j2 * k + i2 * w),
        Vector3::new(i2 * k + j2 * w, j2 * k - i2 * w, 1.0 - i2 * i - j2 * j),
    ]
}

/// The orientation in which most axes are x, y or z: that of the world, or z along the first axis and y along what of
/// another is perpendicular to it.
fn along(axes: &[Axis]) -> UnitQuaternion<f64> {
    let first = axes.first().map_or_else(Vector3::z, |axis| axis.direction);
    let beside = |axis: &Axis| axis.direction - first * first.dot(&axis.direction);
    let second = axes.iter().map(beside).find_map(|beside| beside.try_normalize(0.1));
    let Some(y) = second else { return UnitQuaternion::identity() };
    let basis = [y.cross(&first), y, first];
    let aligned = UnitQuaternion::from_rotation_matrix(&Rotation3::from_basis_unchecked(&basis));
    let skew = |rotation: &UnitQuaternion<f64>| {
        let seen = axes.iter().map(|axis| named(rotation.inverse() * axis.direction).0);
        seen.filter(|direction| matches!(direction, Direction::Skew(_))).count()
    };
    let world = UnitQuaternion::identity();
    if skew(&world) <= skew(&aligned) { world } else { aligned }
}

/// The direction that a unit vector has, and on which side.
fn named(axis: Vector3<f64>) -> (Direction, f64) {
    let across = |i: usize, j: usize| axis[i].abs().max(axis[j].abs());
    if across(1, 2) < ROUND_OFF {
        (Direction::X, axis.x.signum())
    } else if across(0, 2) < ROUND_OFF {
        (Direction::Y, axis.y.signum())
    } else if across(0, 1) < ROUND_OFF {
        (Direction::Z, axis.z.signum())
    } else {
        (Direction::Skew(axis), 1.0)
    }
}
