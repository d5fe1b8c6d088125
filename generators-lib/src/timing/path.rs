//! Paths of joints, and grids on them.

use mrroc::JointVector;

use crate::curve::{CubicSpline, SplinePoint};

/// A path of joints by a parameter, continuously differentiable; on each cell of its grid twice.
pub trait JointPath {
    /// Joint positions [rad or m].
    type Joints: JointVector;

    /// The first and the last parameter.
    fn range(&self) -> (f64, f64);

    /// The path at `u`; where the second derivative jumps, that of the later piece.
    fn at(&self, u: f64) -> SplinePoint<Self::Joints>;

    /// Parameters at which the third derivative jumps, rising; a grid should contain them.
    fn knots(&self) -> &[f64] {
        &[]
    }
}

impl<J: JointVector> JointPath for CubicSpline<J> {
    type Joints = J;

    fn range(&self) -> (f64, f64) {
        CubicSpline::range(self)
    }

    fn at(&self, u: f64) -> SplinePoint<J> {
        CubicSpline::at(self, u)
    }

    fn knots(&self) -> &[f64] {
        CubicSpline::knots(self)
    }
}

/// A grid of about `cells` cells on `path`, with its knots: between two of them cells are equally long.
#[must_use]
pub fn grid<P: JointPath>(path: &P, cells: usize) -> Vec<f64> {
    let (first, last) = path.range();
    let inner = path.knots().iter().copied().filter(|knot| *knot > first && *knot < last);
    let (mut grid, mut from) = (vec![first], first);
    for to in inner.chain([last]) {
        let share = ((to - from) / (last - first) * cells as f64).round().max(1.0);
        // A share that is not a number comes from a range that is none, which the plan refuses.
        let count = if share.is_finite() { share as usize } else { 1 };
        grid.extend((1..count).map(|i| from + (to - from) * i as f64 / count as f64));
        grid.push(to);
        from = to;
    }
    grid
}
