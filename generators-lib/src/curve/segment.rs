//! A straight line.

use super::{Curve, CurveError, CurvePoint, finite};
use nalgebra::Vector3;

/// The straight line between two points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Segment {
    from: Vector3<f64>,
    to: Vector3<f64>,
    tangent: Vector3<f64>,
    length: f64,
}

impl Segment {
    /// Between two points \[m\] that differ.
    ///
    /// # Errors
    /// Points that coincide or are not finite.
    pub fn new(from: Vector3<f64>, to: Vector3<f64>) -> Result<Self, CurveError> {
        finite([&from, &to])?;
        let displacement = to - from;
        let length = (to - from).norm();
        if !(length > 0.0 && length.is_finite()) {
            return Err(CurveError::Coincident);
        }
        Ok(Segment { from, to, tangent: displacement / length, length })
    }
}

impl Curve for Segment {
    fn length(&self) -> f64 {
        self.length
    }

    fn at(&self, s: f64) -> CurvePoint {
        let position = if s >= self.length { self.to } else { self.from + self.tangent * s.max(0.0) };
        CurvePoint { position, tangent: self.tangent, curvature: Vector3::zeros() }
    }
}
