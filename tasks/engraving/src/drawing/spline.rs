//! The natural C2 cubic spline through points over chord length: the reference for the sampler, and the curve that
//! CAD programs draw through fit points.
//!
//! Slopes `m_i` satisfy `h_i m_{i-1} + 2 (h_{i-1} + h_i) m_i + h_{i-1} m_{i+1} = 3 (h_i D_{i-1} + h_{i-1} D_i)` with
//! chord lengths `h` and chord slopes `D`; the second derivative is 0 at both ends.

use super::{Piece, Vec2};
use nalgebra::SVector;

/// A natural cubic spline through points, parametrised by chord length.
#[derive(Clone, Debug)]
pub struct NaturalSpline<const D: usize> {
    points: Vec<SVector<f64, D>>,
    chords: Vec<f64>,
    slopes: Vec<SVector<f64, D>>,
}

impl<const D: usize> NaturalSpline<D> {
    /// The spline through two or more points; `None` for fewer, or where neighbours lie within 1e-9 mm.
    #[must_use]
    pub fn new(points: Vec<SVector<f64, D>>) -> Option<Self> {
        Self::with_ends(points, [None, None])
    }

    /// The spline that begins and ends in these directions, of length 1, where they are given.
    #[must_use]
    pub fn with_ends(points: Vec<SVector<f64, D>>, ends: [Option<SVector<f64, D>>; 2]) -> Option<Self> {
        let chords: Vec<f64> = points.windows(2).map(|w| (w[1] - w[0]).norm()).collect();
        if chords.is_empty() || chords.iter().any(|h| *h <= 1e-9) {
            return None;
        }
        let slopes = slopes(&points, &chords, ends);
        Some(Self { points, chords, slopes })
    }

    /// The number of spans.
    #[must_use]
    pub fn spans(&self) -> usize {
        self.chords.len()
    }

    /// The point \[mm\] at the fraction `f` in 0..=1 of a span.
    #[must_use]
    pub fn point(&self, span: usize, f: f64) -> SVector<f64, D> {
        let (a, b) = (self.points[span], self.points[span + 1]);
        let h = self.chords[span];
        let (m, n) = (self.slopes[span] * h, self.slopes[span + 1] * h);
        let g = 1.0 - f;
        a * (g * g * (1.0 + 2.0 * f)) + m * (f * g * g) + b * (f * f * (3.0 - 2.0 * f)) - n * (f * f * g)
    }
}

impl<const D: usize> NaturalSpline<D> {
    /// The control points of the spans as cubic Bézier curves: the same curve.
    pub fn controls(&self) -> impl Iterator<Item = [SVector<f64, D>; 4]> {
        (0..self.spans()).map(|i| {
            let (a, b, third) = (self.points[i], self.points[i + 1], self.chords[i] / 3.0);
            [a, a + self.slopes[i] * third, b - self.slopes[i + 1] * third, b]
        })
    }
}

impl NaturalSpline<2> {
    /// The spans as cubic Bézier pieces: the same curve.
    #[must_use]
    pub fn pieces(&self) -> Vec<Piece> {
        self.controls().map(Piece::Cubic).collect()
    }
}

/// Thomas' algorithm on the spline's rows: at an end the slope that is given, else no second derivative.
fn slopes<const D: usize>(
    points: &[SVector<f64, D>],
    h: &[f64],
    [first, last]: [Option<SVector<f64, D>>; 2],
) -> Vec<SVector<f64, D>> {
    let n = points.len();
    let slope = |i: usize| (points[i + 1] - points[i]) / h[i];
    if n == 2 && first.is_none() && last.is_none() {
        return vec![slope(0); 2];
    }
    let mut upper = vec![if first.is_none() { 0.5 } else { 0.0 }; n];
    let mut right = vec![first.unwrap_or(slope(0) * 1.5); n];
    for i in 1..n - 1 {
        let pivot = 2.0 * (h[i - 1] + h[i]) - h[i] * upper[i - 1];
        upper[i] = h[i - 1] / pivot;
        let rhs = (slope(i - 1) * h[i] + slope(i) * h[i - 1]) * 3.0;
        right[i] = (rhs - right[i - 1] * h[i]) / pivot;
    }
    right[n - 1] = last.unwrap_or((slope(n - 2) * 3.0 - right[n - 2]) / (2.0 - upper[n - 2]));
    for i in (0..n - 1).rev() {
        let next = right[i + 1];
        right[i] -= next * upper[i];
    }
    right
}

/// A polyline drawn as a smooth curve: runs of vertices that turn by less than `corner` \[rad\] become natural
/// splines, the other vertices stay corners; so do turns of more than 20 degrees between a long and a short side,
/// where a spline would bend the long one. A closed polyline that is smooth at its start stays smooth there.
#[must_use]
pub fn smooth_pieces(vertices: &[Vec2], corner: f64) -> Vec<Piece> {
    let mut points: Vec<Vec2> = Vec::with_capacity(vertices.len());
    for p in vertices {
        if points.last().is_none_or(|last| (p - last).norm() > 1e-6) {
            points.push(*p);
        }
    }
    let n = points.len();
    let closed = n > 3 && (points[0] - points[n - 1]).norm() < 1e-6;
    let breaks: Vec<usize> = (1..n.saturating_sub(1))
        .filter(|&i| is_corner(points[i - 1], points[i], points[i + 1], corner))
        .collect();
    if closed && !is_corner(points[n - 2], points[0], points[1], corner) {
        return smooth_loop(&points[..n - 1], &breaks);
    }
    let mut ends = breaks;
    ends.insert(0, 0);
    ends.push(n.saturating_sub(1));
    ends.windows(2)
        .filter_map(|w| NaturalSpline::new(points[w[0]..=w[1]].to_vec()))
        .flat_map(|s| s.pieces())
        .collect()
}

/// Whether the polyline keeps its corner at `b`.
fn is_corner(a: Vec2, b: Vec2, c: Vec2, corner: f64) -> bool {
    let (before, after) = (b - a, c - b);
    let turn = before.angle(&after);
    let uneven = before.norm().max(after.norm()) > 3.0 * before.norm().min(after.norm());
    turn >= corner || (uneven && turn > 20f64.to_radians())
}

/// The closed cubic spline through points, over chord length: smooth at every one of them.
#[must_use]
pub fn smooth_ring(points: &[Vec2]) -> Vec<Piece> {
    smooth_loop(points, &[])
}

/// A loop that is smooth at its first vertex: started at a corner, or, without one, wrapped far enough around that
/// the natural ends no longer matter (their influence falls to 0.27 per point).
fn smooth_loop(points: &[Vec2], breaks: &[usize]) -> Vec<Piece> {
    let n = points.len();
    let around = |from: usize, count: usize| (0..count).map(|i| points[(from + i) % n]).collect::<Vec<_>>();
    if let Some(first) = breaks.first() {
        let mut ends = breaks.to_vec();
        ends.push(first + n);
        return ends
            .windows(2)
            .filter_map(|w| NaturalSpline::new(around(w[0], w[1] - w[0] + 1)))
            .flat_map(|s| s.pieces())
            .collect();
    }
    let lead = 16;
    let from = (n - lead % n) % n;
    NaturalSpline::new(around(from, 2 * lead + n + 1))
        .map(|s| s.pieces().into_iter().skip(lead).take(n).collect())
        .unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_straight_row_of_uneven_points_stays_straight() {
        let spline =
            NaturalSpline::new([0.0, 1.0, 1.5, 7.0, 9.0].map(|x| Vec2::new(x, 2.0 * x)).to_vec()).unwrap();
        for span in 0..4 {
            let p = spline.point(span, 0.3);
            assert!((p.y - 2.0 * p.x).abs() < 1e-12);
        }
    }

    #[test]
    fn neighbouring_spans_share_slope_and_second_derivative() {
        let points = (0..9).map(|i| Vec2::new(f64::from(i), f64::from(i * i % 7))).collect();
        let spline = NaturalSpline::new(points).unwrap();
        let pieces = spline.pieces();
        for (i, pair) in pieces.windows(2).enumerate() {
            let (h, k) = (spline.chords[i], spline.chords[i + 1]);
            let (d0, s0) = pair[0].derivatives(1.0);
            let (d1, s1) = pair[1].derivatives(0.0);
            assert!((d0 / h - d1 / k).norm() < 1e-12);
            assert!((s0 / (h * h) - s1 / (k * k)).norm() < 1e-11);
        }
        assert!(pieces[0].derivatives(0.0).1.norm() < 1e-12);
    }

    #[test]
    fn a_ring_of_points_becomes_nearly_a_circle() {
        let ring: Vec<Vec2> = (0..=24)
            .map(|i| {
                let a = std::f64::consts::TAU * f64::from(i % 24) / 24.0;
                Vec2::new(a.cos(), a.sin()) * 10.0
            })
            .collect();
        let pieces = smooth_pieces(&ring, 0.6);
        assert_eq!(pieces.len(), 24);
        assert!((pieces[0].start() - ring[0]).norm() < 1e-12);
        for piece in &pieces {
            // Quartic error of a C2 cubic through a circle: below 1e-4 of the radius at 15 degrees.
            assert!((piece.point(0.5).norm() - 10.0).abs() < 1e-3);
        }
    }
}
