//! Control points computed once from the window and then kept: a cubic that is C2 exactly.
//!
//! Non-uniform cubic B-spline on the knots `t`, extended by the end spans. At a knot, with `h_k = t_{k+1} - t_k`:
//!
//! ```text
//! alpha_k c_{k-1} + beta_k c_k + gamma_k c_{k+1} = P_k
//! alpha_k = h_k^2     / ((h_{k-1} + h_k) (h_{k-2} + h_{k-1} + h_k))
//! gamma_k = h_{k-1}^2 / ((h_{k-1} + h_k) (h_{k-1} + h_k + h_{k+1}))     beta_k = 1 - alpha_k - gamma_k
//! ```
//!
//! In the window that starts at `k` the frozen `c_{k-1}` goes to the right-hand side, the far end has `S'' = 0`, and
//! only `c_k` is kept; the first window, with `S'' = 0` at its start, gives `c_{-1}` too. `c_1` comes from a later
//! window than these two, so the curve starts as near to the first point as it passes the others, not at it.

use super::{Part, Span};
use nalgebra::Vector3;

type Point = Vector3<f64>;

/// The last control points and knot spans of a run.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Frozen {
    /// Number of control points frozen, without `c_{-1}`.
    frozen: usize,
    /// `c_{k-3} .. c_k` of the last frozen `c_k`.
    c: [Point; 4],
    /// `h_{k-4} .. h_k`; what lies before the run repeats its first span.
    h: [f64; 5],
    /// Parts of the points `k-1` and `k`.
    parts: [Part; 2],
}

/// Basis values at a knot, and the ratio of its outer supports.
struct Row {
    alpha: f64,
    beta: f64,
    gamma: f64,
    /// `(h_{k-1} + h_k + h_{k+1}) / (h_{k-2} + h_{k-1} + h_k)`.
    ratio: f64,
}

impl Row {
    /// From `h_{k-2}, h_{k-1}, h_k, h_{k+1}`.
    #[inline]
    fn new(h: [f64; 4]) -> Self {
        let middle = h[1] + h[2];
        let left = h[0] + middle;
        let right = middle + h[3];
        let alpha = h[2] * h[2] / (middle * left);
        let gamma = h[1] * h[1] / (middle * right);
        Self { alpha, beta: 1.0 - alpha - gamma, gamma, ratio: right / left }
    }
}

impl Frozen {
    /// Freezes the control point of the window's first point. `h` holds the window's knot spans, one fewer than
    /// `points`. The span two points back is then complete.
    pub(super) fn step(&mut self, points: &[Point], h: &[f64], part: Part) -> Option<(Span, Part)> {
        if self.frozen == 0 {
            self.h = [*h.first()?; 5];
        }
        let here = h.first().copied().unwrap_or(self.h[4]);
        let before = [self.h[3], self.h[4]];
        let c = self.solve(points, h, here, before)?;
        if self.frozen == 0 {
            self.c = [c[0], c[0], c[0], c[1]];
            self.parts = [part; 2];
            self.frozen = 1;
            return None;
        }
        self.push(c[1], here, part)
    }

    /// The last span of the run, which ends at `last`.
    pub(super) fn flush(&mut self, last: Point) -> Option<(Span, Part)> {
        if self.frozen < 2 {
            return None;
        }
        let row = Row::new([self.h[2], self.h[3], self.h[4], self.h[4]]);
        let beyond = self.c[3] + (self.c[3] - self.c[2]) * row.ratio;
        let done = self.push(beyond, self.h[4], Part::Lead);
        *self = Self::default();
        done.map(|(span, part)| (span.ending_at(last), part))
    }

    /// `c_{k-1}` and `c_k` of the window whose first point is `k`.
    #[inline]
    fn solve(&self, points: &[Point], h: &[f64], here: f64, before: [f64; 2]) -> Option<[Point; 2]> {
        let n = points.len();
        let last = h.last().copied().unwrap_or(here);
        let at = |k: isize| match k {
            -2 => before[0],
            -1 => before[1],
            _ => h.get(k.unsigned_abs()).copied().unwrap_or(last),
        };
        let row = |k: usize| {
            let k = k as isize;
            Row::new([at(k - 2), at(k - 1), at(k), at(k + 1)])
        };
        // c_k = r - f c_{k-1}, carried back from the far end.
        let end = row(n.checked_sub(1)?);
        let pivot = 1.0 / (end.beta + end.gamma * (1.0 + end.ratio));
        let mut r = points[n - 1] * pivot;
        let mut f = (end.alpha - end.gamma * end.ratio) * pivot;
        for k in (1..n - 1).rev() {
            let Row { alpha, beta, gamma, .. } = row(k);
            let pivot = 1.0 / (beta - gamma * f);
            r = (points[k] - r * gamma) * pivot;
            f = alpha * pivot;
        }
        if n == 1 {
            return Some([self.c[3], r - self.c[3] * f]);
        }
        let Row { alpha, beta, gamma, ratio } = row(0);
        if self.frozen > 0 {
            let pivot = 1.0 / (beta - gamma * f);
            return Some([self.c[3], (points[0] - r * gamma - self.c[3] * alpha) * pivot]);
        }
        // S'' = 0 at the start: c_{-1} = c_0 - (c_1 - c_0) / ratio.
        let g = gamma - alpha / ratio;
        let c0 = (points[0] - r * g) / (alpha * (1.0 + 1.0 / ratio) + beta - g * f);
        let c1 = r - c0 * f;
        Some([c0 - (c1 - c0) / ratio, c0])
    }

    /// Takes the next control point and the knot span behind it; the span two points back is then complete.
    fn push(&mut self, c: Point, here: f64, part: Part) -> Option<(Span, Part)> {
        self.c = [self.c[1], self.c[2], self.c[3], c];
        self.h = [self.h[1], self.h[2], self.h[3], self.h[4], here];
        let of_span = self.parts[0];
        self.parts = [self.parts[1], part];
        self.frozen += 1;
        if self.frozen < 3 {
            return None;
        }
        let [h0, h1, h2, h3, h4] = self.h;
        let (p0, m0) = knot([self.c[0], self.c[1], self.c[2]], [h0, h1, h2, h3]);
        let (p1, m1) = knot([self.c[1], self.c[2], self.c[3]], [h1, h2, h3, h4]);
        Some((Span::cubic(p0, p1, m0, m1, h2), of_span))
    }
}

/// Position and slope at a knot from its three control points and `h_{k-2} .. h_{k+1}`.
fn knot(c: [Point; 3], h: [f64; 4]) -> (Point, Point) {
    let Row { alpha, beta, gamma, .. } = Row::new(h);
    let before = h[1];
    let after = h[2];
    let d0 = (c[1] - c[0]) * (3.0 / (h[0] + before + after));
    let d1 = (c[2] - c[1]) * (3.0 / (before + after + h[3]));
    (c[0] * alpha + c[1] * beta + c[2] * gamma, (d0 * after + d1 * before) / (before + after))
}
