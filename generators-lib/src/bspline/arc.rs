//! Path length along a span, and its inverse.
//!
//! `L(a, b) = integral of |S'(u)| du`, Gauss-Legendre with 5 and 7 nodes, bisected until both agree to 1e-10.

use super::Span;
use super::gauss::{length_5, length_7};

/// Relative agreement of the 5-node and the 7-node rule at which an interval is accepted.
const AGREEMENT: f64 = 1e-10;
/// Smallest pieces of an interval, accepted as they are: at a cusp.
const GRID: u64 = 1 << 40;

/// Length \[m\] of `span` from parameter `a` to `b` >= `a`.
#[must_use]
pub fn length_between(span: &Span, a: f64, b: f64) -> f64 {
    length_measured(span, a, b).0
}

/// Length, and whether 5 nodes over the whole interval were enough.
pub(crate) fn length_measured(span: &Span, a: f64, b: f64) -> (f64, bool) {
    let whole = length_7(span, a, b);
    if (length_5(span, a, b) - whole).abs() <= AGREEMENT * whole {
        return (whole, true);
    }
    // What overflows agrees with nothing, however finely it is cut.
    if !whole.is_finite() {
        return (whole, false);
    }
    // A dyadic grid: a piece that is refused is halved, one that is accepted is followed by the largest piece that
    // the grid allows there.
    let floor = AGREEMENT * 1e-4 * whole;
    let width = (b - a) / GRID as f64;
    let mut at = 0;
    let mut size = GRID / 2;
    let mut sum = 0.0;
    while at < GRID {
        let start = a + width * at as f64;
        let end = a + width * (at + size) as f64;
        let fine = length_7(span, start, end);
        if size == 1 || (length_5(span, start, end) - fine).abs() <= (AGREEMENT * fine).max(floor) {
            sum += fine;
            at += size;
            size = 1 << at.trailing_zeros();
        } else {
            size /= 2;
        }
    }
    (sum, false)
}

/// Parameter at the length `s` \[m\] behind the parameter `from`, at most `to`: Newton's iteration, kept in a bracket.
#[must_use]
pub fn parameter_at(span: &Span, from: f64, to: f64, s: f64) -> f64 {
    inverse(span, from, to, s, |a, b| length_between(span, a, b))
}

/// As [`parameter_at`], by 5 nodes without bisection, for intervals where these are enough.
#[inline]
pub(crate) fn parameter_at_plain(span: &Span, from: f64, to: f64, s: f64) -> f64 {
    inverse(span, from, to, s, |a, b| length_5(span, a, b))
}

#[inline]
fn inverse(span: &Span, from: f64, to: f64, s: f64, length: impl Fn(f64, f64) -> f64) -> f64 {
    if s <= 0.0 {
        return from;
    }
    // Second-order Taylor start: u = s / |S'| - s^2 (S' . S'') / (2 |S'|^4).
    let slope = span.first(from);
    let speed2 = slope.norm_squared();
    let first_order = s / speed2.sqrt();
    let taylor = first_order * (1.0 - 0.5 * first_order * slope.dot(&span.second(from)) / speed2);
    let mut low = from;
    let mut high = to;
    let mut u = from + taylor;
    if !(u > low && u < high) {
        u = 0.5 * (low + high);
    }
    // Newton doubles the digits of a Taylor start; a bisection step gains one bit: 60 end any search.
    for _ in 0..60 {
        let residual = length(from, u) - s;
        if residual > 0.0 {
            high = u;
        } else {
            low = u;
        }
        let step = residual / span.first(u).norm();
        let newton = u - step;
        if step.abs() <= 1e-6 * (u - from) {
            // Newton's iteration squares the relative error: 1e-12 is left.
            return newton.clamp(from, to);
        }
        u = if newton > low && newton < high { newton } else { 0.5 * (low + high) };
        if high - low <= f64::EPSILON * high.abs() {
            return u;
        }
    }
    u
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;

    /// y = x^2 over 0..1: L = sqrt(5)/2 + asinh(2)/4.
    #[test]
    fn the_length_of_a_parabola_equals_its_closed_form() {
        let span = Span::cubic(
            Vector3::zeros(),
            Vector3::new(1.0, 1.0, 0.0),
            Vector3::x(),
            Vector3::new(1.0, 2.0, 0.0),
            1.0,
        );
        let exact = |x: f64| 0.5 * x * (1.0 + 4.0 * x * x).sqrt() + 0.25 * (2.0 * x).asinh();
        assert!((length_between(&span, 0.0, 1.0) - exact(1.0)).abs() < 1e-10);
        for x in [1e-6, 0.1, 0.5, 0.9, 0.999_999] {
            assert!((parameter_at(&span, 0.0, 1.0, exact(x)) - x).abs() < 1e-10, "{x}");
        }
        assert_eq!(parameter_at(&span, 0.0, 1.0, 0.0), 0.0);
    }

    #[test]
    fn the_length_through_a_cusp_is_found() {
        // (t^2, t^3) about its cusp: L(x) = ((4 + 9 x^2)^1.5 - 8) / 27 on either side.
        let p = |t: f64| Vector3::new(t * t, t * t * t, 0.0);
        let d = |t: f64| Vector3::new(2.0 * t, 3.0 * t * t, 0.0);
        let span = Span::cubic(p(-0.3), p(1.0), d(-0.3), d(1.0), 1.3);
        let side = |x: f64| ((4.0 + 9.0 * x * x).powf(1.5) - 8.0) / 27.0;
        assert!((length_between(&span, 0.0, 1.3) - side(0.3) - side(1.0)).abs() < 1e-9);
    }
}
