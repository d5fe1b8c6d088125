//! One exact curve piece of a stroke, over the parameter 0..=1.

use super::height::{blossom, quadratic_roots};
use super::{Affine, EllipticalArc, Height, RationalBezier, Vec2, cross};

/// An exact curve: line, elliptical or circular arc, cubic Bézier, or a span of a NURBS.
#[derive(Clone, Debug, PartialEq)]
pub enum Piece {
    /// A straight line.
    Line {
        /// Start \[mm\].
        from: Vec2,
        /// End \[mm\].
        to: Vec2,
    },
    /// A circular or elliptical arc.
    Arc(EllipticalArc),
    /// A cubic Bézier curve's control points \[mm\].
    Cubic([Vec2; 4]),
    /// A rational Bézier curve: one span of a NURBS.
    Rational(RationalBezier),
}

impl Piece {
    /// The quadratic Bézier curve, raised to a cubic: the same curve.
    #[must_use]
    pub fn quadratic(a: Vec2, b: Vec2, c: Vec2) -> Self {
        Self::Cubic([a, a + (b - a) * (2.0 / 3.0), c + (b - c) * (2.0 / 3.0), c])
    }

    /// The point at `t` in 0..=1 \[mm\].
    #[must_use]
    pub fn point(&self, t: f64) -> Vec2 {
        match self {
            Self::Line { from, to } => from + (to - from) * t,
            Self::Arc(arc) => arc.point(t),
            Self::Cubic([a, b, c, d]) => {
                let s = 1.0 - t;
                a * (s * s * s) + b * (3.0 * s * s * t) + c * (3.0 * s * t * t) + d * (t * t * t)
            }
            Self::Rational(curve) => curve.evaluate(t).0,
        }
    }

    /// First and second derivative by `t` \[mm\].
    #[must_use]
    pub fn derivatives(&self, t: f64) -> (Vec2, Vec2) {
        match self {
            Self::Line { from, to } => (to - from, Vec2::zeros()),
            Self::Arc(arc) => arc.derivatives(t),
            Self::Cubic([a, b, c, d]) => {
                let s = 1.0 - t;
                let (ab, bc, cd) = (b - a, c - b, d - c);
                (
                    (ab * (s * s) + bc * (2.0 * s * t) + cd * (t * t)) * 3.0,
                    ((bc - ab) * s + (cd - bc) * t) * 6.0,
                )
            }
            Self::Rational(curve) => {
                let (_, first, second) = curve.evaluate(t);
                (first, second)
            }
        }
    }

    /// The first derivative by `t` \[mm\].
    #[must_use]
    pub fn derivative(&self, t: f64) -> Vec2 {
        self.derivatives(t).0
    }

    /// The unit tangent; where the derivative vanishes (control points that coincide), its limit from inside.
    #[must_use]
    pub fn tangent(&self, t: f64) -> Vec2 {
        let mut step = 1e-6;
        let mut d = self.derivative(t);
        let inward = if t < 0.5 { 1.0 } else { -1.0 };
        while d.norm() < 1e-9 && step < 0.3 {
            d = (self.point(t + inward * step) - self.point(t)) * inward;
            step *= 10.0;
        }
        let norm = d.norm();
        if norm > 0.0 { d / norm } else { Vec2::new(1.0, 0.0) }
    }

    /// The signed curvature at `t` \[1/mm\], positive where the curve turns left; 0 where it is not defined.
    #[must_use]
    pub fn curvature(&self, t: f64) -> f64 {
        let (d, dd) = self.derivatives(t);
        let speed = d.norm();
        if speed > 1e-9 { cross(d, dd) / (speed * speed * speed) } else { 0.0 }
    }

    /// The start \[mm\].
    #[must_use]
    pub fn start(&self) -> Vec2 {
        self.point(0.0)
    }

    /// The end \[mm\].
    #[must_use]
    pub fn end(&self) -> Vec2 {
        self.point(1.0)
    }

    /// The same piece travelled in the other direction.
    #[must_use]
    pub fn reversed(&self) -> Self {
        match self {
            Self::Line { from, to } => Self::Line { from: *to, to: *from },
            Self::Arc(arc) => Self::Arc(arc.reversed()),
            Self::Cubic([a, b, c, d]) => Self::Cubic([*d, *c, *b, *a]),
            Self::Rational(curve) => Self::Rational(curve.reversed()),
        }
    }

    /// The piece's image under an affine map.
    #[must_use]
    pub fn transformed(&self, map: &Affine) -> Self {
        match self {
            Self::Line { from, to } => Self::Line { from: map.point(*from), to: map.point(*to) },
            Self::Arc(arc) => Self::Arc(arc.transformed(map)),
            Self::Cubic(controls) => Self::Cubic(controls.map(|p| map.point(p))),
            Self::Rational(curve) => Self::Rational(curve.transformed(map)),
        }
    }

    /// The arc length \[mm\], to 1e-6 relative: 5-point Gauss-Legendre over equal parts.
    #[must_use]
    pub fn length(&self) -> f64 {
        match self {
            Self::Line { from, to } => (to - from).norm(),
            Self::Arc(_) | Self::Cubic(_) | Self::Rational(_) => integral(|t| self.derivative(t).norm()),
        }
    }

    /// The length of the tip's path along the piece at these heights \[mm\].
    #[must_use]
    pub fn length_at(&self, height: &Height) -> f64 {
        match (self, height) {
            (Self::Line { from, to }, Height::Linear { from: low, to: high }) => {
                (to - from).norm().hypot(high - low)
            }
            _ => integral(|t| self.derivative(t).norm().hypot(height.derivatives(t).0)),
        }
    }

    /// The part between two parameters, over 0..=1 again. A rational piece stays whole: its heights never change.
    #[must_use]
    pub fn part(&self, from: f64, to: f64) -> Self {
        match self {
            Self::Line { .. } => Self::Line { from: self.point(from), to: self.point(to) },
            Self::Arc(arc) => Self::Arc(EllipticalArc {
                start_angle: arc.angle(from),
                sweep: arc.sweep * (to - from),
                ..*arc
            }),
            Self::Cubic(controls) => {
                let blossom = |x, y, z| blossom(*controls, [x, y, z], |a, b, f| a + (b - a) * f);
                Self::Cubic([
                    blossom(from, from, from),
                    blossom(from, from, to),
                    blossom(from, to, to),
                    blossom(to, to, to),
                ])
            }
            Self::Rational(_) => self.clone(),
        }
    }

    /// Parameters strictly inside 0..1 where x or y may be extreme; empty for rational pieces, which are flattened.
    pub(super) fn extremes(&self) -> Vec<f64> {
        match self {
            Self::Line { .. } | Self::Rational(_) => Vec::new(),
            Self::Arc(arc) => arc.extremes().collect(),
            Self::Cubic([a, b, c, d]) => {
                let (ab, bc, cd) = (b - a, c - b, d - c);
                let mut found = Vec::new();
                for axis in 0..2 {
                    let (p, q, r) = (ab[axis], bc[axis], cd[axis]);
                    quadratic_roots(p - 2.0 * q + r, 2.0 * (q - p), p, &mut found);
                }
                found.retain(|t| *t > 0.0 && *t < 1.0);
                found
            }
        }
    }

    /// Whether every number in it is finite and of a size that a plate could have, |x| < 1e7 mm.
    #[must_use]
    pub fn is_sane(&self) -> bool {
        let ok = |p: &Vec2| p.x.abs() < 1e7 && p.y.abs() < 1e7;
        match self {
            Self::Line { from, to } => ok(from) && ok(to),
            Self::Arc(arc) => {
                ok(&arc.centre)
                    && ok(&arc.u)
                    && ok(&arc.v)
                    && arc.start_angle.is_finite()
                    && arc.sweep.abs() < 1e3
            }
            Self::Cubic(controls) => controls.iter().all(ok),
            Self::Rational(curve) => curve.controls().iter().all(|(p, _)| ok(p)),
        }
    }
}

/// The integral over 0..=1 of a smooth function.
fn integral(of: impl Fn(f64) -> f64) -> f64 {
    const PARTS: usize = 16;
    const NODES: [(f64, f64); 3] = [
        (0.0, 0.568_888_888_888_888_9),
        (0.538_469_310_105_683_1, 0.478_628_670_499_366_5),
        (0.906_179_845_938_664, 0.236_926_885_056_189_1),
    ];
    let half = 0.5 / PARTS as f64;
    let mut sum = 0.0;
    for part in 0..PARTS {
        let middle = (2 * part + 1) as f64 * half;
        for (x, weight) in NODES {
            sum += weight * of(middle + half * x);
            if x > 0.0 {
                sum += weight * of(middle - half * x);
            }
        }
    }
    sum * half
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_circle_has_its_length_and_curvature() {
        let circle = Piece::Arc(EllipticalArc::circular(Vec2::zeros(), 5.0, 0.3, std::f64::consts::TAU));
        assert!((circle.length() - 31.415_926_535_897_93).abs() < 1e-9);
        assert!((circle.curvature(0.4) - 0.2).abs() < 1e-12);
        assert!((circle.reversed().curvature(0.4) + 0.2).abs() < 1e-12);
    }

    #[test]
    fn a_tangent_exists_where_control_points_coincide() {
        let a = Vec2::new(1.0, 1.0);
        let piece = Piece::Cubic([a, a, Vec2::new(2.0, 2.0), Vec2::new(3.0, 1.0)]);
        assert!((piece.tangent(0.0) - Vec2::new(1.0, 1.0).normalize()).norm() < 1e-3);
    }
}
