//! A path in space by its length.

use nalgebra::Vector3;

use super::{Curve, CurveError, CurvePoint, Parametric};

/// Relative agreement of a cell's quadrature with that of its halves.
const AGREEMENT: f64 = 1e-11;
/// Smallest cell, as a share of a knot span: at a cusp.
const SMALLEST: f64 = 1e-9;
/// Nodes and weights of the quadrature by Gauss and Legendre with 5 nodes, on -1..1 (Abramowitz and Stegun, table 25.4).
const NODES: [(f64, f64); 5] = [
    (-0.906_179_845_938_664, 0.236_926_885_056_189_08),
    (-0.538_469_310_105_683_1, 0.478_628_670_499_366_47),
    (0.0, 0.568_888_888_888_888_9),
    (0.538_469_310_105_683_1, 0.478_628_670_499_366_47),
    (0.906_179_845_938_664, 0.236_926_885_056_189_08),
];

/// A path in space by its length: cells on which five nodes measure the length to 1e-11 of it, and Newton's iteration on
/// each. Where the path stands still (a cusp), the tangent is that beside it.
#[derive(Clone, Debug, PartialEq)]
pub struct ByLength<P> {
    path: P,
    /// Ends of the cells: parameter, and length so far \[m\].
    cells: Vec<(f64, f64)>,
}

impl<P: Parametric<Value = Vector3<f64>>> ByLength<P> {
    /// The lengths along `path`.
    ///
    /// # Errors
    /// A path without length, or that is not finite.
    pub fn new(path: P) -> Result<Self, CurveError> {
        let (first, last) = path.range();
        let mut cells = vec![(first, 0.0)];
        let inner: Vec<_> = path.knots().iter().copied().filter(|u| *u > first && *u < last).collect();
        let mut from = first;
        let mut length = 0.0;
        for to in inner.into_iter().chain([last]) {
            let mut u = from;
            let mut size = to - from;
            while u < to {
                let end = if u + size >= to { to } else { u + size };
                let whole = measure(&path, u, end);
                let middle = 0.5 * (u + end);
                let halves = measure(&path, u, middle) + measure(&path, middle, end);
                if !halves.is_finite() {
                    return Err(CurveError::NotFinite);
                }
                if (whole - halves).abs() > AGREEMENT * halves && size > SMALLEST * (to - from) {
                    size *= 0.5;
                    continue;
                }
                length += halves;
                cells.push((end, length));
                u = end;
                size *= 2.0;
            }
            from = to;
        }
        if length > 0.0 { Ok(ByLength { path, cells }) } else { Err(CurveError::Coincident) }
    }

    /// The path.
    #[must_use]
    pub fn path(&self) -> &P {
        &self.path
    }

    /// The parameter at the length `s` \[m\].
    #[must_use]
    pub fn parameter(&self, s: f64) -> f64 {
        let i = self.cells.partition_point(|cell| cell.1 <= s).clamp(1, self.cells.len() - 1);
        let ((from, before), (to, after)) = (self.cells[i - 1], self.cells[i]);
        let within = (s - before).clamp(0.0, after - before);
        if within == 0.0 || s >= after {
            return if within == 0.0 { from } else { to };
        }
        let mut low = from;
        let mut high = to;
        let mut u = from + (to - from) * within / (after - before);
        // Newton doubles the digits; where it leaves the bracket, bisection gains one bit.
        for _ in 0..60 {
            let residual = measure(&self.path, from, u) - within;
            if residual > 0.0 {
                high = u
            } else {
                low = u
            }
            let newton = u - residual / self.path.at(u).first.norm();
            let inside = newton > low && newton < high;
            let step = if inside { newton - u } else { 0.5 * (low + high) - u };
            u += step;
            if step.abs() <= 1e-9 * (to - from) && inside || step == 0.0 {
                break;
            }
        }
        u
    }
}

/// Length from `a` to `b` by five nodes.
fn measure<P: Parametric<Value = Vector3<f64>>>(path: &P, a: f64, b: f64) -> f64 {
    let middle = 0.5 * (a + b);
    let half = 0.5 * (b - a);
    half * NODES.iter().map(|(x, weight)| weight * path.at(middle + half * x).first.norm()).sum::<f64>()
}

impl<P: Parametric<Value = Vector3<f64>>> Curve for ByLength<P> {
    fn length(&self) -> f64 {
        self.cells[self.cells.len() - 1].1
    }

    fn at(&self, s: f64) -> CurvePoint {
        let u = self.parameter(s);
        let (first, last) = self.path.range();
        let at = self.path.at(u);
        let beside = if at.first.norm_squared() > 0.0 {
            at
        } else {
            let off = SMALLEST * (last - first);
            self.path.at(if u + off < last { u + off } else { u - off })
        };
        let speed2 = beside.first.norm_squared();
        let tangent = beside.first / speed2.sqrt();
        let across = beside.second - tangent * beside.second.dot(&tangent);
        CurvePoint { position: at.value, tangent, curvature: across / speed2 }
    }
}
