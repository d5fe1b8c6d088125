//! Polylines with blended corners.
//!
//! A corner P between the directions t and t' is cut by a parabola from `P - d t` to `P + d t'`, tangent to both. It
//! passes the corner at `d |t - t'| / 4 = (d / 2) sin(turn / 2)`.

use super::{CurveError, SpanCurve};
use crate::bspline::Span;
use crate::waypoints;
use nalgebra::Vector3;

/// Share of a leg that the blends at either of its ends may take.
const HALF: f64 = 0.5;

/// The polyline through `points` \[m\] with its corners blended by parabolas that pass them at `deviation` \[m\], > 0, or
/// nearer where legs are short. Points count by the rule of [`waypoints`].
///
/// Its tangent is continuous, its curvature is not. A corner that turns straight back is not blended: nothing passes
/// there without stopping.
///
/// # Errors
/// Fewer than two points that differ, a number that is not finite, a deviation that is not positive.
pub fn blended(points: &[Vector3<f64>], deviation: f64) -> Result<SpanCurve, CurveError> {
    let corners = waypoints::places(points)?;
    if !(deviation.is_finite() && deviation > 0.0) {
        return Err(CurveError::Deviation(deviation));
    }
    let (first, last) = (corners[0], corners[corners.len() - 1]);
    let line = |a: Vector3<f64>, b: Vector3<f64>| Span::cubic(a, b, b - a, b - a, 1.0);
    let mut spans = Vec::with_capacity(2 * corners.len());
    let mut at = first;
    for corner in corners.windows(3) {
        let before = corner[1] - corner[0];
        let after = corner[2] - corner[1];
        let t = before.normalize();
        let u = after.normalize();
        let bend = (t - u).norm();
        let reach = if bend > 0.0 { 4.0 * deviation / bend } else { 0.0 };
        let d = reach.min(HALF * before.norm()).min(HALF * after.norm());
        // A parabola that turns straight back has a cusp, where the motion would have to stop.
        let d = if (t + u).norm() < 1e-9 { 0.0 } else { d };
        let begin = corner[1] - t * d;
        let end = corner[1] + u * d;
        spans.push(line(at, begin));
        if d > 0.0 {
            // The quadratic Bezier curve with the corner as its control point, as a cubic.
            spans.push(Span::cubic(begin, end, t * (2.0 * d), u * (2.0 * d), 1.0));
        }
        at = end;
    }
    spans.push(line(at, last));
    SpanCurve::new(spans)
}
