//! An ellipse, or a part of one.
//!
//! `p = c + a cos u + b sin u`; its length has no closed form: Gauss-Legendre with 7 nodes on each of 64 panels, and
//! Newton's iteration for the inverse.

use super::{Curve, CurveError, CurvePoint, finite};
use nalgebra::Vector3;

const PANELS: usize = 64;
/// Nodes and weights on -1..1 (Abramowitz and Stegun, table 25.4).
const NODES: [(f64, f64); 7] = [
    (0.0, 0.417_959_183_673_469_4),
    (0.405_845_151_377_397_2, 0.381_830_050_505_118_9),
    (-0.405_845_151_377_397_2, 0.381_830_050_505_118_9),
    (0.741_531_185_599_394_4, 0.279_705_391_489_276_67),
    (-0.741_531_185_599_394_4, 0.279_705_391_489_276_67),
    (0.949_107_912_342_758_5, 0.129_484_966_168_869_7),
    (-0.949_107_912_342_758_5, 0.129_484_966_168_869_7),
];

/// An elliptic arc.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ellipse {
    centre: Vector3<f64>,
    axes: [Vector3<f64>; 2],
    from: f64,
    panel: f64,
    /// Length to the end of each panel \[m\].
    lengths: [f64; PANELS],
}

impl Ellipse {
    /// About `centre` with the semi-axes `a` and `b` \[m\], at right angles, from the parameter `from` to `to` \[rad\]:
    /// 0 is at `centre + a`, a quarter turn at `centre + b`.
    ///
    /// # Errors
    /// Axes that are not at right angles, an axis or a range of zero, a number that is not finite.
    pub fn new(
        centre: Vector3<f64>,
        a: Vector3<f64>,
        b: Vector3<f64>,
        from: f64,
        to: f64,
    ) -> Result<Self, CurveError> {
        finite([&centre, &a, &b])?;
        if !(from.is_finite() && to.is_finite()) {
            return Err(CurveError::NotFinite);
        }
        let cosine = a.normalize().dot(&b.normalize());
        if !(a.norm() > 0.0 && b.norm() > 0.0 && from != to) {
            return Err(CurveError::Coincident);
        }
        if cosine.abs() > 1e-9 {
            return Err(CurveError::Skew(cosine));
        }
        // Backwards is forwards on the mirrored axis.
        let (b, from, to) = if to < from { (-b, -from, -to) } else { (b, from, to) };
        let panel = (to - from) / PANELS as f64;
        let mut ellipse = Ellipse { centre, axes: [a, b], from, panel, lengths: [0.0; PANELS] };
        let mut sum = 0.0;
        for i in 0..PANELS {
            let begin = from + panel * i as f64;
            sum += ellipse.length_between(begin, begin + panel);
            ellipse.lengths[i] = sum;
        }
        if sum.is_finite() { Ok(ellipse) } else { Err(CurveError::NotFinite) }
    }

    fn speed(&self, u: f64) -> f64 {
        let (sin, cos) = u.sin_cos();
        (self.axes[1] * cos - self.axes[0] * sin).norm()
    }

    fn length_between(&self, u: f64, v: f64) -> f64 {
        let middle = 0.5 * (u + v);
        let half = 0.5 * (v - u);
        half * NODES.iter().map(|(x, weight)| weight * self.speed(middle + x * half)).sum::<f64>()
    }

    /// Parameter at the length `s`.
    fn parameter(&self, s: f64) -> f64 {
        let panel = self.lengths.partition_point(|length| *length <= s).min(PANELS - 1);
        let start = if panel == 0 { 0.0 } else { self.lengths[panel - 1] };
        let low = self.from + self.panel * panel as f64;
        let high = self.from + self.panel * (panel + 1) as f64;
        let mut u = low + self.panel * (s - start) / (self.lengths[panel] - start);
        // Within one of 64 panels the start is so near that four steps reach the last digit.
        for _ in 0..4 {
            u = (u - (self.length_between(low, u) - (s - start)) / self.speed(u)).clamp(low, high);
        }
        u
    }
}

impl Curve for Ellipse {
    fn length(&self) -> f64 {
        self.lengths[PANELS - 1]
    }

    fn at(&self, s: f64) -> CurvePoint {
        let (sin, cos) = self.parameter(s.clamp(0.0, self.length())).sin_cos();
        let [a, b] = self.axes;
        let first = b * cos - a * sin;
        let second = -(a * cos + b * sin);
        let i = 1.0 / first.norm();
        let tangent = first * i;
        CurvePoint {
            position: self.centre - second,
            tangent,
            curvature: (second - tangent * tangent.dot(&second)) * (i * i),
        }
    }
}
