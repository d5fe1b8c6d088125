//! Recognises chains that have a closed form: six revolute joints, ortho-parallel, with a spherical wrist.

use mrroc::pose::Pose;
use mrroc::robot::JointKind;
use nalgebra::{Translation3, UnitQuaternion, Vector3};

use super::chain::Segment;
use super::motion::{Axis, at_zero};
use crate::models::opw::OrthoParallel;

/// How far axes may be from perpendicular or parallel (cosine, sine) and from meeting \[m\]: round-off.
const EXACT: f64 = 1e-12;

/// Length below which a link counts as missing \[m\].
const NO_LINK: f64 = 1e-6;

/// The closed form of the chain, if it has one. The axes are looked at where all joints are at 0.
#[allow(non_snake_case)]
pub(super) fn ortho_parallel(segments: &[Segment], X_tip: &Pose) -> Option<OrthoParallel> {
    let plain = |(i, segment): (usize, &Segment)| {
        segment.kind == JointKind::Revolute
            && segment.leader == i
            && segment.multiplier == 1.0
            && segment.offset == 0.0
    };
    if segments.len() != 6 || !segments.iter().enumerate().all(plain) {
        return None;
    }
    let (axes, X_WF) = at_zero(segments, X_tip);
    let z = |i: usize| axes[i].direction;
    let perpendicular = |i: usize, j: usize| z(i).dot(&z(j)).abs() < EXACT;
    let ortho_parallel = perpendicular(0, 1) && z(1).cross(&z(2)).norm() < EXACT && perpendicular(2, 3);
    let ortho_wrist = perpendicular(3, 4) && perpendicular(4, 5);
    let centre = nearest(&axes[4], &axes[3]);
    if !ortho_parallel || !ortho_wrist || off(&axes[3], &centre) > EXACT || off(&axes[5], &centre) > EXACT {
        return None;
    }
    // O on axis 1, level with axis 2. With z up already, it keeps the directions of the world.
    let up = z(0);
    let p_WO = axes[0].point + up * up.dot(&(axes[1].point - axes[0].point));
    let R_WO = UnitQuaternion::rotation_between(&Vector3::z(), &up)
        .unwrap_or_else(|| UnitQuaternion::from_axis_angle(&Vector3::x_axis(), core::f64::consts::PI));
    let X_WO = Pose::from_parts(Translation3::from(p_WO), R_WO);
    // Where axis 2 points along y, theta1 is 0; at q = 0 the arm's plane stands at o1.
    let second = R_WO.inverse() * z(1);
    let o1 = (-second.x).atan2(second.y);
    let R_WA = R_WO * UnitQuaternion::from_axis_angle(&Vector3::z_axis(), o1);
    let in_plane = |v: Vector3<f64>| R_WA.inverse() * v;
    let at_2 = in_plane(axes[1].point - p_WO);
    let upper = in_plane(axes[2].point - axes[1].point);
    let fore = in_plane(centre - axes[2].point);
    let l = upper.x.hypot(upper.z);
    let k = fore.x.hypot(fore.z);
    if l < NO_LINK || k < NO_LINK {
        return None;
    }
    let about = |axis, angle| UnitQuaternion::from_axis_angle(&axis, angle);
    // Turn by turn to the frame of each wrist axis: z along axis 4, y along axis 5, z along axis 6.
    let fourth = in_plane(z(3));
    let o23 = fourth.x.atan2(fourth.z);
    let R_W4 = R_WA * about(Vector3::y_axis(), o23);
    let fifth = R_W4.inverse() * z(4);
    let o4 = (-fifth.x).atan2(fifth.y);
    let R_W5 = R_W4 * about(Vector3::z_axis(), o4);
    let sixth = R_W5.inverse() * z(5);
    let o5 = sixth.x.atan2(sixth.z);
    let R_WC = R_W5 * about(Vector3::y_axis(), o5);
    let delta = fore.x.atan2(fore.z) - o23;
    Some(OrthoParallel {
        X_WO,
        R_CF: R_WC.inverse() * X_WF.rotation,
        p_CF: R_WC.inverse() * (X_WF.translation.vector - centre),
        a1: at_2.x,
        b: in_plane(centre - p_WO).y,
        l,
        k,
        offsets: [o1, upper.x.atan2(upper.z), o23, o4, o5, 0.0],
        third: z(1).dot(&z(2)).signum(),
        delta,
        delta_sin_cos: delta.sin_cos(),
    })
}

/// The point of `line` nearest to `other`, which is perpendicular to it.
fn nearest(line: &Axis, other: &Axis) -> Vector3<f64> {
    line.point + line.direction * line.direction.dot(&(other.point - line.point))
}

/// Distance of a point from an axis \[m\].
fn off(axis: &Axis, point: &Vector3<f64>) -> f64 {
    axis.direction.cross(&(point - axis.point)).norm()
}
