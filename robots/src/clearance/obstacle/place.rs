//! Where an obstacle stands: points of the world in its frame, and back.
#![allow(non_snake_case)]

use mrroc::pose::Pose;
use nalgebra::{Point3, Vector3};

use crate::clearance::gap::Gap;

/// Whether all numbers of a pose are finite.
pub(super) fn is_finite(pose: &Pose) -> bool {
    pose.translation.vector.iter().chain(pose.rotation.coords.iter()).all(|x| x.is_finite())
}

/// A point of the world in the frame O of an obstacle.
pub(super) fn seen_from(X_WO: &Pose, p: &Vector3<f64>) -> Vector3<f64> {
    X_WO.inverse_transform_point(&Point3::from(*p)).coords
}

/// The gap in the world between a capsule of this radius \[m\] and a solid body, of which the nearest points of the capsule's
/// segment and of the body are given in O.
pub(super) fn gap_in(X_WO: &Pose, points: [Vector3<f64>; 2], radius: f64) -> Gap {
    Gap::between(points.map(|p| X_WO.transform_point(&Point3::from(p)).coords), [radius, 0.0])
}
