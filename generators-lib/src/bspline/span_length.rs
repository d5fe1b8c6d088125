//! The length of a span as a polynomial of its parameter, for many points on one span.
//!
//! With `x = 2 u / h - 1` the speed `|S'|` is interpolated at the eight nodes of Chebyshev's `T_8`, in `x^2` for its
//! even and its odd part, and integrated. The error is that of the terms left out, which go on falling as the last ones
//! do: with `c_k` the size of the terms of `T_k`, about `(c_6 + c_7)^2 / (c_4 + c_5)` in the speed, and a fourteenth of it
//! in the length. A span that this leaves above 1e-10 of its length has no such polynomial. Source: Trefethen, *Approximation Theory and Approximation Practice*,
//! chapters 4 and 8.

use super::Span;

/// Positive nodes: `cos((2 k + 1) pi / 16)`.
const NODES: [f64; 4] =
    [0.980_785_280_403_230_4, 0.831_469_612_302_545_2, 0.555_570_233_019_602_2, 0.195_090_322_016_128_27];
/// Their squares.
const Y: [f64; 4] = [NODES[0] * NODES[0], NODES[1] * NODES[1], NODES[2] * NODES[2], NODES[3] * NODES[3]];
/// Terms left out that do not matter, as a share of the mean speed.
const ERROR: f64 = 1e-9;
/// Least speed at an end, as a share of the mean speed.
const LEAST_SPEED: f64 = 0.01;
/// Terms as small as rounding makes them.
const ROUNDING: f64 = 1e-14;

/// The length of one span by its parameter, and its inverse, to 1e-10 of the span's length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpanLength {
    /// Half the knot span.
    half: f64,
    /// `L = sum_k q_k x^(k+1) - start` \[m\].
    q: [f64; 8],
    start: f64,
}

/// Coefficients of the cubic in `y` through four values at [`Y`], by divided differences.
#[inline]
fn cubic(f: [f64; 4]) -> [f64; 4] {
    const BY: [f64; 6] = [
        1.0 / (Y[1] - Y[0]),
        1.0 / (Y[2] - Y[1]),
        1.0 / (Y[3] - Y[2]),
        1.0 / (Y[2] - Y[0]),
        1.0 / (Y[3] - Y[1]),
        1.0 / (Y[3] - Y[0]),
    ];
    let a = (f[1] - f[0]) * BY[0];
    let b = (f[2] - f[1]) * BY[1];
    let c = (f[3] - f[2]) * BY[2];
    let d = (b - a) * BY[3];
    let e = (c - b) * BY[4];
    let g = (e - d) * BY[5];
    // f0 + (y - y0) (a + (y - y1) (d + (y - y2) g)), multiplied out.
    let quadratic = d - g * (Y[0] + Y[1] + Y[2]);
    let linear = a - d * (Y[0] + Y[1]) + g * (Y[0] * Y[1] + Y[0] * Y[2] + Y[1] * Y[2]);
    [f[0] - a * Y[0] + d * Y[0] * Y[1] - g * Y[0] * Y[1] * Y[2], linear, quadratic, g]
}

impl SpanLength {
    /// Of `span`; `None` where eight nodes are too few, as near a cusp.
    #[must_use]
    pub fn new(span: &Span) -> Option<Self> {
        let half = 0.5 * span.knot_span();
        let speed = |x: f64| span.first(half * (1.0 + x)).norm();
        let mut even = [0.0; 4];
        let mut odd = [0.0; 4];
        for (k, x) in NODES.into_iter().enumerate() {
            let ahead = speed(x);
            let behind = speed(-x);
            even[k] = 0.5 * (ahead + behind);
            odd[k] = 0.5 * (ahead - behind) / x;
        }
        let e = cubic(even);
        let o = cubic(odd);
        // T_6 = 32 x^6 - 48 x^4 .., T_7 = 64 x^7 - 112 x^5 .., T_4 = 8 x^4 .., T_5 = 16 x^5 ..
        let c6 = e[3] / 32.0;
        let c7 = o[3] / 64.0;
        let c4 = (e[2] + 48.0 * c6) / 8.0;
        let c5 = (o[2] + 112.0 * c7) / 16.0;
        let last = c6.abs() + c7.abs();
        let before = c4.abs() + c5.abs();
        let mean = even[1];
        if !(last <= ROUNDING * mean || last * last <= ERROR * mean * before) {
            return None;
        }
        let c = [e[0], o[0], e[1], o[1], e[2], o[2], e[3], o[3]];
        let mut length = SpanLength { half, q: [0.0; 8], start: 0.0 };
        length.q = core::array::from_fn(|k| half * c[k] / (k + 1) as f64);
        let [start, speed, _] = length.taylor(-1.0);
        length.start = start;
        // Where the curve all but stands still at an end, its length says little of the parameter.
        let slowest = speed.min(length.taylor(1.0)[1]);
        (slowest >= LEAST_SPEED * half * mean).then_some(length)
    }

    /// The antiderivative and its first two derivatives by `x`.
    #[inline]
    fn taylor(&self, x: f64) -> [f64; 3] {
        let q = &self.q;
        let x2 = x * x;
        let x4 = x2 * x2;
        // By pairs (Estrin), which do not wait for each other.
        let pairs = |c: [f64; 8]| {
            ((c[0] + c[1] * x) + (c[2] + c[3] * x) * x2) + ((c[4] + c[5] * x) + (c[6] + c[7] * x) * x2) * x4
        };
        let first: [f64; 8] = core::array::from_fn(|k| (k + 1) as f64 * q[k]);
        let second = core::array::from_fn(|k| if k < 7 { (k + 1) as f64 * first[k + 1] } else { 0.0 });
        [x * pairs(*q), pairs(first), pairs(second)]
    }

    /// Length \[m\] from the start of the span to the parameter `u`.
    #[inline]
    #[must_use]
    pub fn to(&self, u: f64) -> f64 {
        self.taylor(u / self.half - 1.0)[0] - self.start
    }

    /// Parameter at the length `s` \[m\] from the start of the span, found from one that is `near`: Halley's iteration.
    #[inline]
    #[must_use]
    pub fn parameter_at(&self, s: f64, near: f64) -> f64 {
        let target = s + self.start;
        let mut x = near / self.half - 1.0;
        for _ in 0..16 {
            let [p, first, second] = self.taylor(x);
            let slope = 1.0 / first;
            let newton = (p - target) * slope;
            let step = newton * (1.0 + 0.5 * newton * second * slope);
            x = (x - step).clamp(-1.0, 1.0);
            // The error that is left is of the order of its cube.
            if step.abs() <= 1e-5 {
                break;
            }
        }
        self.half * (1.0 + x)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bspline::{length_between, parameter_at};
    use nalgebra::Vector3;

    /// Some 15 degrees of a circle of radius 1 and a piece of a parabola.
    fn spans() -> [Span; 2] {
        let (sin, cos) = (std::f64::consts::PI / 12.0).sin_cos();
        let p = Vector3::new(cos, sin, 0.0);
        let t = Vector3::new(-sin, cos, 0.0);
        let circle = Span::cubic(Vector3::x(), p, Vector3::y() * 0.998, t * 0.998, (p - Vector3::x()).norm());
        let end = Vector3::new(0.15, 0.0225, 0.0);
        [circle, Span::cubic(Vector3::zeros(), end, Vector3::x(), Vector3::new(1.0, 0.3, 0.0), 0.15)]
    }

    #[test]
    fn lengths_and_parameters_agree_with_those_by_quadrature() {
        for span in spans() {
            let table = SpanLength::new(&span).expect("smooth");
            let h = span.knot_span();
            let whole = length_between(&span, 0.0, h);
            for i in 0..=100 {
                let u = f64::from(i) * 0.01 * h;
                let exact = length_between(&span, 0.0, u);
                assert!((table.to(u) - exact).abs() < 1e-10 * whole, "{u}: {} {exact}", table.to(u));
                for near in [0.0, 0.4 * h, h] {
                    let back = table.parameter_at(exact, near);
                    let by_quadrature = parameter_at(&span, 0.0, h, exact);
                    assert!((back - by_quadrature).abs() < 1e-10 * h, "{u}: {back} {by_quadrature}");
                }
            }
        }
    }

    /// y = x^2: L = x sqrt(1 + 4 x^2) / 2 + asinh(2 x) / 4.
    #[test]
    fn the_length_of_a_parabola_equals_its_closed_form() {
        let table = SpanLength::new(&spans()[1]).expect("smooth");
        let exact = |x: f64| 0.5 * x * (1.0 + 4.0 * x * x).sqrt() + 0.25 * (2.0 * x).asinh();
        assert!((0..=30).map(|i| f64::from(i) * 0.005).all(|x| (table.to(x) - exact(x)).abs() < 1.5e-11));
    }

    #[test]
    fn a_cusp_and_what_is_not_finite_have_no_polynomial() {
        let p = |t: f64| Vector3::new(t * t, t * t * t, 0.0);
        let d = |t: f64| Vector3::new(2.0 * t, 3.0 * t * t, 0.0);
        assert_eq!(SpanLength::new(&Span::cubic(p(-0.3), p(1.0), d(-0.3), d(1.0), 1.3)), None);
        // A cusp at an end, of which the speed is a polynomial all the same.
        let zero = Vector3::zeros();
        let x = Vector3::x();
        assert_eq!(SpanLength::new(&Span::cubic(zero, x, zero, x * 2.0, 1.0)), None);
        let nan = Vector3::repeat(f64::NAN);
        assert_eq!(SpanLength::new(&Span::cubic(nan, p(1.0), d(0.0), d(1.0), 1.0)), None);
    }
}
