//! The points that a path leads through: one rule for all paths.
//!
//! In: points of joints, poses or places, as a program gives them, with the start before them. Out: those that count, each apart
//! from the one before. Points nearer to each other than [`ONE_POINT`] are one, so a path may begin where the robot is, and a
//! list may name a point twice, without a stop there. The last point is always where the path ends, to the bit.

use mrroc::pose::Pose;
use mrroc::robot::JointVector;
use nalgebra::Vector3;
use thiserror::Error;

/// Points that are nearer than this are one: in each joint [rad or m]; of poses, the distance of the origins \[m\] and the angle
/// between the orientations \[rad\].
pub const ONE_POINT: f64 = 1e-6;

/// Why points make no path.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum PointsError {
    /// A coordinate of the point at this place is infinite or not a number.
    #[error(
        "point {0} of the path has a coordinate that is infinite or not a number (point 0 is where the path begins)"
    )]
    NotFinite(usize),
    /// No two points are apart.
    #[error("the points of the path are all one: none is farther than {ONE_POINT} rad or m from the first")]
    Coincident,
}

/// The points of joints that count.
///
/// ```
/// use mrroc_generators::waypoints::{PointsError, joints};
/// use nalgebra::Vector2;
///
/// let (a, b) = (Vector2::new(0.1, 0.2), Vector2::new(0.3, 0.2));
/// let nearly_b = Vector2::new(0.3, 0.2 + 1e-9);
/// assert_eq!(joints(&[a, a, b, nearly_b]), Ok(vec![a, nearly_b]));
/// assert_eq!(joints(&[a, Vector2::new(f64::NAN, 0.0)]), Err(PointsError::NotFinite(1)));
/// assert_eq!(joints(&[a, a]), Err(PointsError::Coincident));
/// ```
///
/// # Errors
/// A point with a coordinate that is not finite; no two that are apart.
pub fn joints<J: JointVector>(points: &[J]) -> Result<Vec<J>, PointsError> {
    let near = |a: &J, b: &J| (*a - *b).as_slice().iter().all(|x| x.abs() < ONE_POINT);
    apart(points, J::is_finite, near)
}

/// The poses that count.
///
/// # Errors
/// As [`joints`].
pub fn poses(points: &[Pose]) -> Result<Vec<Pose>, PointsError> {
    let finite = |pose: &Pose| {
        pose.translation.vector.iter().chain(pose.rotation.coords.iter()).all(|x| x.is_finite())
    };
    let near = |a: &Pose, b: &Pose| {
        (a.translation.vector - b.translation.vector).norm() < ONE_POINT
            && (a.rotation.inverse() * b.rotation).scaled_axis().norm() < ONE_POINT
    };
    apart(points, finite, near)
}

/// The places \[m\] that count.
///
/// # Errors
/// As [`joints`].
pub fn places(points: &[Vector3<f64>]) -> Result<Vec<Vector3<f64>>, PointsError> {
    let near = |a: &Vector3<f64>, b: &Vector3<f64>| (a - b).norm() < ONE_POINT;
    apart(points, |point| point.iter().all(|x| x.is_finite()), near)
}

fn apart<P: Copy + PartialEq>(
    points: &[P],
    finite: impl Fn(&P) -> bool,
    near: impl Fn(&P, &P) -> bool,
) -> Result<Vec<P>, PointsError> {
    if let Some(place) = points.iter().position(|point| !finite(point)) {
        return Err(PointsError::NotFinite(place));
    }
    let mut kept: Vec<P> = Vec::with_capacity(points.len());
    for point in points {
        if kept.last().is_none_or(|before| !near(before, point)) {
            kept.push(*point);
        }
    }
    match (kept.as_mut_slice(), points.last()) {
        ([_, .., end], Some(last)) => *end = *last,
        _ => return Err(PointsError::Coincident),
    }
    Ok(kept)
}

/// Knots of a spline through points by the distance between them, the chord: from 0 on.
pub(crate) fn knots<P>(points: &[P], chord: impl Fn(&P, &P) -> f64) -> Vec<f64> {
    let knots = points.windows(2).scan(0.0, |u, pair| {
        *u += chord(&pair[0], &pair[1]);
        Some(*u)
    });
    core::iter::once(0.0).chain(knots).collect()
}

/// The distance between two points of joints.
pub(crate) fn chord<J: JointVector>(from: &J, to: &J) -> f64 {
    (*to - *from).as_slice().iter().map(|x| x * x).sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector1;

    #[test]
    fn points_that_creep_on_count_as_soon_as_they_are_apart() {
        // Each is nearer than the tolerance to the one before it, and the eleventh is apart from the first.
        let points: Vec<_> = (0..=30).map(|i| Vector1::new(f64::from(i) * 1.1e-7)).collect();
        let kept = joints(&points).expect("a path");
        assert_eq!(kept.first(), points.first());
        assert_eq!(kept.last(), points.last());
        assert_eq!(kept.len(), 4, "{kept:?}");
    }

    #[test]
    fn a_pose_counts_that_is_only_turned_and_one_with_the_other_sign_of_its_quaternion_does_not() {
        let here = Pose::translation(0.1, 0.2, 0.3) * Pose::rotation(Vector3::x() * 0.4);
        let turned = here * Pose::rotation(Vector3::z() * 1e-3);
        let mut negative = here;
        negative.rotation = nalgebra::UnitQuaternion::new_unchecked(-here.rotation.into_inner());
        assert_eq!(poses(&[here, negative, turned]), Ok(vec![here, turned]));
    }
}
