//! The spline through poses, twice continuously differentiable.

use mrroc::pose::Pose;
use nalgebra::{Translation3, Vector3};

use super::{CubicSpline, CurveError, RotationSpline, SplineEnds};
use crate::waypoints;

/// A natural cubic spline of the origin and a [`RotationSpline`], by one parameter: velocity and acceleration, linear and
/// angular, do not jump.
#[derive(Clone, Debug, PartialEq)]
pub struct PoseSpline {
    origin: CubicSpline<Vector3<f64>>,
    orientation: RotationSpline,
}

/// Upper bounds of the derivatives of a pose by its parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PoseBounds {
    /// First and second of the origin \[m\].
    pub translation: (f64, f64),
    /// Angular velocity and acceleration \[rad\].
    pub rotation: (f64, f64),
}

impl PoseSpline {
    /// Through `poses` in one common frame \[m\] at rising `knots`, two or more.
    ///
    /// # Errors
    /// As [`CubicSpline::new`] and [`RotationSpline::new`].
    pub fn new(knots: Vec<f64>, poses: &[Pose]) -> Result<Self, CurveError> {
        let origins = poses.iter().map(|pose| pose.translation.vector).collect();
        let origin = CubicSpline::new(knots.clone(), origins, SplineEnds::Natural)?;
        let orientation = RotationSpline::new(knots, poses.iter().map(|pose| pose.rotation).collect())?;
        Ok(PoseSpline { origin, orientation })
    }

    /// Through `poses` \[m\] that count by the rule of [`waypoints`], at knots by their distances: a radian counts as `turn`
    /// metres.
    ///
    /// # Errors
    /// [`CurveError::Points`]: a number that is not finite, or no two poses that are apart; as [`RotationSpline::new`].
    pub fn by_chords(poses: &[Pose], turn: f64) -> Result<Self, CurveError> {
        let poses = waypoints::poses(poses)?;
        let chord = |from: &Pose, to: &Pose| {
            let by = from.inv_mul(to);
            by.translation.vector.norm().hypot(turn * by.rotation.angle())
        };
        PoseSpline::new(waypoints::knots(&poses, chord), &poses)
    }

    /// The first and the last knot.
    #[must_use]
    pub fn range(&self) -> (f64, f64) {
        self.origin.range()
    }

    /// The pose at `u`; at its knots exactly those given.
    #[must_use]
    pub fn at(&self, u: f64) -> Pose {
        Pose::from_parts(Translation3::from(self.origin.at(u).value), self.orientation.at(u).0)
    }

    /// What the derivatives by the parameter do not exceed.
    #[must_use]
    pub fn bounds(&self) -> PoseBounds {
        let mut first = 0.0_f64;
        let mut second = 0.0_f64;
        for pair in self.origin.knots().windows(2) {
            let from = self.origin.at(pair[0]);
            let to = self.origin.at(pair[1].next_down());
            // The slope is a parabola within the hull of its ends and its control point.
            let control = from.first + from.second * (0.5 * (pair[1] - pair[0]));
            first = first.max(from.first.norm()).max(control.norm()).max(to.first.norm());
            second = second.max(from.second.norm()).max(to.second.norm());
        }
        PoseBounds { translation: (first, second), rotation: self.orientation.bounds() }
    }
}
