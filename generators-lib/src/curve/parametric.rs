//! Paths by a parameter of any kind.

use mrroc::robot::JointVector;

use super::{CubicSpline, SplinePoint};

/// A path of vectors (of joints, of points in space) by a parameter, continuously differentiable; between its knots, and on
/// each cell of a grid laid on it, twice.
pub trait Parametric {
    /// Joint positions [rad or m], or points in space \[m\].
    type Value: JointVector;

    /// The first and the last parameter.
    fn range(&self) -> (f64, f64);

    /// The path at `u`; where the second derivative jumps, that of the later piece.
    fn at(&self, u: f64) -> SplinePoint<Self::Value>;

    /// Parameters at which the second or third derivative jumps, rising; a grid should contain them.
    fn knots(&self) -> &[f64] {
        &[]
    }
}

impl<V: JointVector> Parametric for CubicSpline<V> {
    type Value = V;

    fn range(&self) -> (f64, f64) {
        CubicSpline::range(self)
    }

    fn at(&self, u: f64) -> SplinePoint<V> {
        CubicSpline::at(self, u)
    }

    fn knots(&self) -> &[f64] {
        CubicSpline::knots(self)
    }
}
