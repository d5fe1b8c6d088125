//! Curves in space by their length, and cubic splines through any vectors.
//!
//! In: points, axes, angles. Out: position, unit tangent and curvature vector at any length along the curve. A
//! [`Profile`](crate::profile::Profile) of the length makes a motion of it: with `s` the length,
//! `v = s' t`, `a = s'' t + s'^2 k`.
//!
//! | curve | length |
//! |---|---|
//! | [`Segment`] | exact |
//! | [`Arc`], through three points or about an axis | exact |
//! | [`Helix`] | exact |
//! | [`Ellipse`], whole or in part | quadrature, error below 1e-9 of the long axis for axes up to 1 : 20 |
//! | [`ByLength`] of a [`Nurbs`] or of a [`CubicSpline`] in space | quadrature, error below 1e-9 but near cusps |
//! | [`SpanCurve`]: [`blended`] polylines, splines in space | quadrature, error below 1e-9 but near cusps |
//!
//! [`TurnedCurve`] leads a tool along any of them while it turns, [`CurveBody`] a body at its start's orientation;
//! [`Screw`] is the screw motion between two poses; [`CubicSpline`]
//! interpolates vectors of any dimension, such as joints, or smooths them, twice continuously differentiable; so are the
//! [`RotationSpline`] through orientations and the [`PoseSpline`] through poses.

mod arc;
mod body;
mod by_length;
mod cubic_spline;
mod ellipse;
mod helix;
mod nurbs;
mod parametric;
mod polyline;
mod pose_spline;
mod rotation_spline;
mod screw;
mod segment;
mod sine;
mod smoothing;
mod spans;
mod turned;

pub use arc::Arc;
pub use body::CurveBody;
pub use by_length::ByLength;
pub use cubic_spline::{CubicSpline, SplineEnds, SplinePoint};
pub use ellipse::Ellipse;
pub use helix::Helix;
pub use nurbs::Nurbs;
pub use parametric::Parametric;
pub use polyline::blended;
pub use pose_spline::{PoseBounds, PoseSpline};
pub use rotation_spline::RotationSpline;
pub use screw::Screw;
pub use segment::Segment;
pub use spans::SpanCurve;
pub use turned::TurnedCurve;

use nalgebra::Vector3;
use thiserror::Error;

use crate::waypoints::PointsError;

/// A curve at one length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CurvePoint {
    /// Position \[m\].
    pub position: Vector3<f64>,
    /// Unit tangent: the first derivative by the length.
    pub tangent: Vector3<f64>,
    /// Curvature vector [1/m]: the second derivative by the length; at a joint of pieces, that of the later one.
    pub curvature: Vector3<f64>,
}

/// A curve in space, by its length.
pub trait Curve {
    /// Length \[m\], > 0.
    fn length(&self) -> f64;

    /// The curve at the length `s` \[m\] from its start; beyond its ends it stays there.
    fn at(&self, s: f64) -> CurvePoint;
}

/// Why there is no curve.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum CurveError {
    /// A coordinate, a radius or an angle is infinite or not a number.
    #[error("a coordinate, radius or angle of the curve is not finite")]
    NotFinite,
    /// The points make no path.
    #[error(transparent)]
    Points(#[from] PointsError),
    /// Points that must differ do not, or an axis has no direction.
    #[error("points of the curve coincide, or its axis, radius or angle is zero")]
    Coincident,
    /// Three points on a line are on no circle.
    #[error("the three points lie on a line: there is no circle through them")]
    Collinear,
    /// The axes of an ellipse are not at right angles.
    #[error("the axes of the ellipse are not at right angles: the cosine between them is {0}")]
    Skew(f64),
    /// A spline of fewer than two knots, or of knots and points that do not match or do not rise.
    #[error("a spline needs two points or more, one per knot, and knots that rise")]
    Knots,
    /// A weight of a spline, or its smoothing, is negative or none, or their number does not match the points.
    #[error("a spline's weights must be greater than 0, one per point, its smoothing 0 or more, all finite")]
    Weights,
    /// Orientations so far apart that no smooth path between them is found.
    #[error("the orientations turn too far from knot to knot for a smooth path: help: put more between them")]
    Turn,
    /// The deviation allowed at corners is not positive.
    #[error("the deviation {0} m allowed at corners must be finite and greater than 0")]
    Deviation(f64),
}

/// Whether all coordinates are numbers.
fn finite<'a>(points: impl IntoIterator<Item = &'a Vector3<f64>>) -> Result<(), CurveError> {
    if points.into_iter().all(|p| p.iter().all(|x| x.is_finite())) {
        Ok(())
    } else {
        Err(CurveError::NotFinite)
    }
}
