//! Elliptical arcs, circles among them: `P(θ) = c + u cos θ + v sin θ` with conjugate half-diameters `u`, `v`.
//!
//! This form is closed under every affine map, so a circle in a skewed group stays exact.

use super::{Affine, Vec2, cross};
use std::f64::consts::{PI, TAU};

/// An arc of an ellipse or a circle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EllipticalArc {
    /// Centre \[mm\].
    pub centre: Vec2,
    /// The half-diameter at θ = 0 \[mm\].
    pub u: Vec2,
    /// The conjugate half-diameter, at θ = π/2 \[mm\].
    pub v: Vec2,
    /// Parameter of the start \[rad\].
    pub start_angle: f64,
    /// Parameter travelled \[rad\], negative against the sense from `u` to `v`.
    pub sweep: f64,
}

impl EllipticalArc {
    /// A circular arc: counter-clockwise where y points up and `sweep` > 0.
    #[must_use]
    pub fn circular(centre: Vec2, radius: f64, start_angle: f64, sweep: f64) -> Self {
        Self { centre, u: Vec2::new(radius, 0.0), v: Vec2::new(0.0, radius), start_angle, sweep }
    }

    /// The circular arc from `from` to `to` with the given bulge, tan of a quarter of its angle, positive
    /// counter-clockwise (DXF); `None` for a straight or empty one.
    #[must_use]
    pub fn from_bulge(from: Vec2, to: Vec2, bulge: f64) -> Option<Self> {
        let chord = to - from;
        let length = chord.norm();
        if bulge.abs() < 1e-9 || length < 1e-12 {
            return None;
        }
        let sweep = 4.0 * bulge.atan();
        let left = Vec2::new(-chord.y, chord.x) / length;
        let centre = from + chord * 0.5 + left * (length * (1.0 - bulge * bulge) / (4.0 * bulge));
        Some(Self::about(centre, from, sweep))
    }

    /// The circular arc about `centre` that starts at `from` and turns by `sweep` \[rad\].
    #[must_use]
    pub fn about(centre: Vec2, from: Vec2, sweep: f64) -> Self {
        let u = from - centre;
        Self { centre, u, v: Vec2::new(-u.y, u.x), start_angle: 0.0, sweep }
    }

    /// The arc of SVG's `A` command: radii, turn of the x axis \[rad\], the two flags (SVG 2, appendix B.2.4).
    ///
    /// Radii that are too small grow as the standard demands; `None` where it demands a straight line.
    #[must_use]
    pub fn from_endpoints(
        from: Vec2,
        to: Vec2,
        radii: Vec2,
        turn: f64,
        large_arc: bool,
        sweep: bool,
    ) -> Option<Self> {
        let (mut rx, mut ry) = (radii.x.abs(), radii.y.abs());
        if rx < 1e-12 || ry < 1e-12 || (to - from).norm() < 1e-12 {
            return None;
        }
        let (sin, cos) = turn.sin_cos();
        let half = (from - to) * 0.5;
        let p = Vec2::new(cos * half.x + sin * half.y, -sin * half.x + cos * half.y);
        let excess = (p.x / rx).powi(2) + (p.y / ry).powi(2);
        if excess > 1.0 {
            rx *= excess.sqrt();
            ry *= excess.sqrt();
        }
        // On the unit circle of the ellipse's own axes.
        let (px, py) = (p.x / rx, p.y / ry);
        let square = px * px + py * py;
        let factor = ((1.0 - square).max(0.0) / square).sqrt() * if large_arc == sweep { -1.0 } else { 1.0 };
        let (cx, cy) = (factor * py, -factor * px);
        let start = (py - cy).atan2(px - cx);
        let end = (-py - cy).atan2(-px - cx);
        let mut angle = end - start;
        if sweep && angle < 0.0 {
            angle += TAU;
        } else if !sweep && angle > 0.0 {
            angle -= TAU;
        }
        let u = Vec2::new(cos, sin) * rx;
        let v = Vec2::new(-sin, cos) * ry;
        let centre = (from + to) * 0.5 + u * cx + v * cy;
        Some(Self { centre, u, v, start_angle: start, sweep: angle })
    }

    /// Parameter of the ellipse at `t` in 0..=1 \[rad\].
    #[must_use]
    pub fn angle(&self, t: f64) -> f64 {
        self.start_angle + self.sweep * t
    }

    /// The point at `t` in 0..=1 \[mm\].
    #[must_use]
    pub fn point(&self, t: f64) -> Vec2 {
        let (sin, cos) = self.angle(t).sin_cos();
        self.centre + self.u * cos + self.v * sin
    }

    /// First and second derivative by `t` \[mm\].
    #[must_use]
    pub fn derivatives(&self, t: f64) -> (Vec2, Vec2) {
        let (sin, cos) = self.angle(t).sin_cos();
        (
            (self.v * cos - self.u * sin) * self.sweep,
            (self.u * cos + self.v * sin) * (-self.sweep * self.sweep),
        )
    }

    /// The same arc travelled in the other direction.
    #[must_use]
    pub fn reversed(&self) -> Self {
        Self { start_angle: self.start_angle + self.sweep, sweep: -self.sweep, ..*self }
    }

    /// The arc's image.
    #[must_use]
    pub fn transformed(&self, map: &Affine) -> Self {
        Self { centre: map.point(self.centre), u: map.direction(self.u), v: map.direction(self.v), ..*self }
    }

    /// An upper bound of |P''(t)| \[mm\].
    #[must_use]
    pub fn second_derivative_bound(&self) -> f64 {
        self.sweep * self.sweep * self.longest_half_axis()
    }

    /// The longer half-axis \[mm\]: the larger singular value of [u v].
    #[must_use]
    pub fn longest_half_axis(&self) -> f64 {
        let sum = self.u.norm_squared() + self.v.norm_squared();
        let area = cross(self.u, self.v);
        ((sum + (sum * sum - 4.0 * area * area).max(0.0).sqrt()) * 0.5).sqrt()
    }

    /// Parameters in 0..1 where x or y is extreme.
    pub fn extremes(&self) -> impl Iterator<Item = f64> {
        let (start, sweep) = (self.start_angle, self.sweep);
        [self.v.x.atan2(self.u.x), self.v.y.atan2(self.u.y)].into_iter().flat_map(move |angle| {
            (0..2).filter_map(move |half| {
                let ahead = (angle + f64::from(half) * PI - start) * sweep.signum();
                let t = ahead.rem_euclid(TAU) / sweep.abs();
                (t < 1.0).then_some(t)
            })
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quarter_of_bulge_is_a_quarter_circle() {
        let bulge = (PI / 8.0).tan();
        let arc = EllipticalArc::from_bulge(Vec2::new(1.0, 0.0), Vec2::new(0.0, 1.0), bulge).unwrap();
        assert!(arc.centre.norm() < 1e-12);
        assert!((arc.point(0.5) - Vec2::new(0.5f64.sqrt(), 0.5f64.sqrt())).norm() < 1e-12);
        assert!((arc.point(1.0) - Vec2::new(0.0, 1.0)).norm() < 1e-12);
    }

    #[test]
    fn the_four_arcs_between_two_points_hit_both_and_differ() {
        let (a, b) = (Vec2::new(0.0, 0.0), Vec2::new(3.0, 1.0));
        let mut middles = Vec::new();
        for large in [false, true] {
            for sweep in [false, true] {
                let arc =
                    EllipticalArc::from_endpoints(a, b, Vec2::new(4.0, 2.0), 0.3, large, sweep).unwrap();
                assert!((arc.point(0.0) - a).norm() < 1e-12 && (arc.point(1.0) - b).norm() < 1e-12);
                assert_eq!(large, arc.sweep.abs() > PI);
                assert_eq!(sweep, arc.sweep > 0.0);
                middles.push(arc.point(0.5));
            }
        }
        for i in 0..4 {
            for j in 0..i {
                assert!((middles[i] - middles[j]).norm() > 0.1);
            }
        }
    }

    #[test]
    fn the_half_axis_of_a_sheared_circle_is_its_singular_value() {
        let arc = EllipticalArc::circular(Vec2::zeros(), 2.0, 0.0, TAU)
            .transformed(&Affine::new(1.0, 0.0, 1.0, 1.0, 0.0, 0.0));
        // Singular value of [[1, 1], [0, 1]]: the golden ratio.
        assert!((arc.longest_half_axis() - 2.0 * 1.618_033_988_749_895).abs() < 1e-12);
    }
}
