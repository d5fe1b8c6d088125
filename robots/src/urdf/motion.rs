//! Direct kinematics of a chain, link by link, and its Jacobian.

use mrroc::{JointKind, Pose};
use nalgebra::{Quaternion, SMatrix, SVector, Translation3, UnitQuaternion, Vector3};

use super::chain::{MOST_SEGMENTS, Segment};
use crate::sines::sin_cos;

/// Where an axis lies in the world: its direction, and a point on it \[m\].
#[derive(Clone, Copy)]
pub(super) struct Axis {
    pub(super) direction: Vector3<f64>,
    pub(super) point: Vector3<f64>,
}

/// Pose of the tip at `q` [rad or m]; `visit` is given the index of each segment and its axis.
#[inline(always)]
#[allow(non_snake_case)]
fn travel<const N: usize>(
    segments: &[Segment],
    X_tip: &Pose,
    q: &SVector<f64, N>,
    mut visit: impl FnMut(usize, Axis),
) -> Pose {
    let segments = &segments[..segments.len().min(MOST_SEGMENTS)];
    let mut values = [0.0; MOST_SEGMENTS];
    for (value, segment) in values.iter_mut().zip(segments) {
        *value = segment.multiplier * q[segment.leader] + segment.offset;
    }
    let (mut sines, mut cosines) = ([0.0; MOST_SEGMENTS], [0.0; MOST_SEGMENTS]);
    for i in (0..segments.len()).step_by(2) {
        let (s, c) = sin_cos([0.5 * values[i], 0.5 * values[i + 1]]);
        [sines[i], sines[i + 1]] = s;
        [cosines[i], cosines[i + 1]] = c;
    }
    let mut position = Vector3::zeros();
    let mut rotation = UnitQuaternion::identity();
    for (i, segment) in segments.iter().enumerate() {
        position += rotation * segment.X_before.translation.vector;
        rotation *= segment.X_before.rotation;
        visit(i, Axis { direction: z_of(&rotation), point: position });
        match segment.kind {
            JointKind::Revolute => rotation = turned(&rotation, sines[i], cosines[i]),
            JointKind::Prismatic => position += z_of(&rotation) * values[i],
        }
    }
    position += rotation * X_tip.translation.vector;
    Pose::from_parts(Translation3::from(position), rotation * X_tip.rotation)
}

/// The third column of a rotation matrix.
#[inline(always)]
fn z_of(rotation: &UnitQuaternion<f64>) -> Vector3<f64> {
    let q = rotation.quaternion();
    Vector3::new(
        2.0 * (q.i * q.k + q.w * q.j),
        2.0 * (q.j * q.k - q.w * q.i),
        1.0 - 2.0 * (q.i * q.i + q.j * q.j),
    )
}

/// `rotation R_z(angle)`, from sine and cosine of half the angle.
#[inline(always)]
fn turned(rotation: &UnitQuaternion<f64>, s: f64, c: f64) -> UnitQuaternion<f64> {
    let q = rotation.quaternion();
    UnitQuaternion::new_unchecked(Quaternion::new(
        q.w * c - q.k * s,
        q.i * c + q.j * s,
        q.j * c - q.i * s,
        q.k * c + q.w * s,
    ))
}

/// Pose of the tip at `q` [rad or m].
#[allow(non_snake_case)]
pub(super) fn forward<const N: usize>(segments: &[Segment], X_tip: &Pose, q: &SVector<f64, N>) -> Pose {
    travel(segments, X_tip, q, |_, _| {})
}

/// Axes of all segments at `q`, and the pose of the tip.
#[allow(non_snake_case)]
pub(super) fn axes<const N: usize>(
    segments: &[Segment],
    X_tip: &Pose,
    q: &SVector<f64, N>,
) -> ([Axis; MOST_SEGMENTS], Pose) {
    let mut axes = [Axis { direction: Vector3::zeros(), point: Vector3::zeros() }; MOST_SEGMENTS];
    let pose = travel(segments, X_tip, q, |i, axis| axes[i] = axis);
    (axes, pose)
}

/// Pose of the tip and geometric Jacobian at `q`: per coordinate the velocity of the tip's origin (rows 0 to 2), then
/// its angular velocity (rows 3 to 5), both in the world. A joint that follows adds to its leader's column.
#[allow(non_snake_case)]
pub(super) fn jacobian<const N: usize>(
    segments: &[Segment],
    X_tip: &Pose,
    q: &SVector<f64, N>,
) -> (Pose, SMatrix<f64, 6, N>) {
    let (axes, pose) = axes(segments, X_tip, q);
    let mut jacobian = SMatrix::<f64, 6, N>::zeros();
    for (segment, axis) in segments.iter().zip(&axes) {
        let (angular, linear) = match segment.kind {
            JointKind::Revolute => {
                (axis.direction, axis.direction.cross(&(pose.translation.vector - axis.point)))
            }
            JointKind::Prismatic => (Vector3::zeros(), axis.direction),
        };
        let mut column = jacobian.column_mut(segment.leader);
        for i in 0..3 {
            column[i] += segment.multiplier * linear[i];
            column[i + 3] += segment.multiplier * angular[i];
        }
    }
    (pose, jacobian)
}
