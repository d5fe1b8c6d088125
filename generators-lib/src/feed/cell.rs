//! A piece of a span with one speed limit.

use super::FeedLimits;
use crate::bspline::{Span, SpanLength, length_measured};
use nalgebra::Vector3;

/// Most cells of one span, a power of two: four halvings.
pub(super) const CELLS_PER_SPAN: usize = 16;
/// A bound of the curvature this much above the curvature found is near enough, and does not depend on where the span was cut.
const NEAR: f64 = 1.05;
/// Two curvatures whose relative difference is below this count as the same: a window of the spline makes such differences.
const SAME: f64 = 1e-2;

/// A piece of a span with one speed limit, and what the planner allows at its start.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cell {
    pub(super) span: Span,
    /// First and last parameter.
    pub(super) u: [f64; 2],
    /// Length \[m\].
    pub(super) length: f64,
    /// The span's length by its parameter, where that is a polynomial, and the length at the first parameter \[m\].
    pub(super) by_parameter: Option<(SpanLength, f64)>,
    /// Whether 5 Gauss nodes suffice for lengths within it.
    pub(super) plain: bool,
    /// Square of the speed limit [m^2/s^2].
    pub(super) limit2: f64,
    /// Curvature at the first and at the last point [1/m].
    curvature: [f64; 2],
    /// Square of the speed limit at the first and at the last point, which falls and rises evenly in between.
    pub(super) top2: [f64; 2],
    /// Square of the speed limit of its first point alone.
    pub(super) join2: f64,
    /// Square of the speed planned at its first point.
    pub(super) entry2: f64,
}

impl Cell {
    /// None, for a place that is to take one.
    pub(super) fn empty() -> Self {
        let zero = Vector3::zeros();
        let span = Span::cubic(zero, zero, zero, zero, 1.0);
        Cell {
            span,
            u: [0.0; 2],
            length: 0.0,
            by_parameter: None,
            plain: true,
            limit2: 0.0,
            curvature: [0.0; 2],
            top2: [0.0; 2],
            join2: 0.0,
            entry2: 0.0,
        }
    }

    /// Where the curvature goes on from `self` into `next`, so do the limits that it sets: without this every cell would be
    /// entered and left at the lower limit of two, and travelled at its own, by full acceleration up and down.
    pub(super) fn join(&mut self, next: &mut Cell, feed: f64) {
        let ours = self.curvature[1];
        let theirs = next.curvature[0];
        let goes_on = (ours - theirs).abs() <= SAME * ours.max(theirs);
        if goes_on && self.limit2.max(next.limit2) < feed * feed {
            let lower = self.limit2.min(next.limit2);
            self.top2[1] = lower;
            next.top2[0] = lower;
        }
    }
}

/// Cuts `span` into cells, in order; their widths are equal, since what varied would show in the acceleration.
pub(super) fn cut(span: &Span, limits: &FeedLimits, mut take: impl FnMut(Cell)) {
    let table = SpanLength::new(span);
    let mut count = 1;
    while count < CELLS_PER_SPAN && (0..count).any(|i| is_too_wide(span, parameters(span, i, count), limits))
    {
        count *= 2;
    }
    for i in 0..count {
        let u @ [start, end] = parameters(span, i, count);
        let (bound, curvature) = curvature_bound(span, start, end);
        // So is the same distance from the curvature found, where the bound is nearer than it must be.
        let limit = limits.speed_at_curvature(bound.max(NEAR * curvature[0].max(curvature[1])));
        let limit = limit.min(jerk_limit(span, start, end, limits));
        let by_parameter = table.map(|table| (table, table.to(start)));
        let (length, plain) = match &by_parameter {
            Some((table, from)) => (table.to(end) - from, true),
            None => length_measured(span, start, end),
        };
        let limit2 = limit * limit;
        let span = *span;
        let top2 = [limit2; 2];
        let join2 = limit2;
        let entry2 = 0.0;
        take(Cell { span, u, length, by_parameter, plain, limit2, curvature, top2, join2, entry2 });
    }
}

/// First and last parameter of cell `i` of `count`.
fn parameters(span: &Span, i: usize, count: usize) -> [f64; 2] {
    let h = span.knot_span();
    let width = span.knot_span() / count as f64;
    [width * i as f64, if i + 1 == count { h } else { width * (i + 1) as f64 }]
}

/// Whether the curvature of a cell limits its speed, by a bound that is far from the curvature found.
fn is_too_wide(span: &Span, [start, end]: [f64; 2], limits: &FeedLimits) -> bool {
    let (bound, curvature) = curvature_bound(span, start, end);
    limits.speed_at_curvature(bound) < limits.feed && bound > NEAR * curvature[0].max(curvature[1])
}

/// A bound of the curvature [1/m] over `a..=b`, and the curvatures at its ends.
fn curvature_bound(span: &Span, a: f64, b: f64) -> (f64, [f64; 2]) {
    let eighth = 0.125 * (b - a) * (b - a);
    let start = span.at(a);
    let end = span.at(b);
    let larger = |x: f64, y: f64| x.max(y);
    let fifth = (span.fourth(b) - span.fourth(a)).norm() / (b - a);
    let m4 = larger(span.fourth(a).norm(), span.fourth(b).norm());
    let m3 = larger(start.third.norm(), end.third.norm()) + eighth * fifth;
    let m2 = larger(start.second.norm(), end.second.norm()) + eighth * m4;
    let m1 = larger(start.first.norm(), end.first.norm()) + eighth * m3;
    // f = S' x S'', f'' = S'' x S''' + S' x S''''
    let bend = larger(start.first.cross(&start.second).norm(), end.first.cross(&end.second).norm())
        + eighth * (m2 * m3 + m1 * m4);
    // |S'| is nowhere less than the chord between its end values, less its deviation from that chord.
    let chord = end.first - start.first;
    let along = -start.first.dot(&chord) / chord.norm_squared();
    let nearest = if along > 0.0 { start.first + chord * along.min(1.0) } else { start.first };
    let least = nearest.norm() - eighth * m3;
    let bound = if least > 0.0 { bend / (least * least * least) } else { f64::INFINITY };
    (bound, [start.curvature(), end.curvature()])
}

/// Speed limit [m/s] by jerk, from the ends and the middle.
fn jerk_limit(span: &Span, a: f64, b: f64, limits: &FeedLimits) -> f64 {
    if !limits.jerk.is_finite() {
        return f64::INFINITY;
    }
    let jerk = |u: f64| span.at(u).by_length()[2].norm();
    limits.speed_at_jerk(jerk(a).max(jerk(0.5 * (a + b))).max(jerk(b)))
}
