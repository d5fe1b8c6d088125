//! One polynomial piece of the curve.

use nalgebra::Vector3;

/// A cubic or quintic `S(u) = sum_k c_k u^k`, `u` in `0..=h`, `u` in units of the knots.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Span {
    c: [Vector3<f64>; 6],
    h: f64,
    end: Vector3<f64>,
}

/// Position and the first three derivatives by the parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpanGeometry {
    /// `S` \[m\].
    pub position: Vector3<f64>,
    /// `S'` [m per unit of the parameter].
    pub first: Vector3<f64>,
    /// `S''`.
    pub second: Vector3<f64>,
    /// `S'''`.
    pub third: Vector3<f64>,
}

impl Span {
    /// The cubic between two points \[m\] with slopes `m0`, `m1` over the knot span `h` > 0.
    #[must_use]
    #[inline]
    pub fn cubic(p0: Vector3<f64>, p1: Vector3<f64>, m0: Vector3<f64>, m1: Vector3<f64>, h: f64) -> Self {
        let i = 1.0 / h;
        let d = (p1 - p0) * i;
        let c2 = (d * 3.0 - m0 * 2.0 - m1) * i;
        let c3 = (m0 + m1 - d * 2.0) * (i * i);
        Self { c: [p0, m0, c2, c3, Vector3::zeros(), Vector3::zeros()], h, end: p1 }
    }

    /// The quintic between two states (position \[m\], slope, second derivative) over the knot span `h` > 0.
    #[must_use]
    #[inline]
    pub fn quintic(start: [Vector3<f64>; 3], end: [Vector3<f64>; 3], h: f64) -> Self {
        let [p0, v0, a0] = start;
        let [p1, v1, a1] = end;
        let d = p1 - p0 - v0 * h - a0 * (0.5 * h * h);
        let v = (v1 - v0 - a0 * h) * h;
        let a = (a1 - a0) * (0.5 * h * h);
        let i = 1.0 / h;
        let i3 = i * i * i;
        let c3 = (d * 10.0 - v * 4.0 + a) * i3;
        let c4 = (d * -15.0 + v * 7.0 - a * 2.0) * (i3 * i);
        let c5 = (d * 6.0 - v * 3.0 + a) * (i3 * i * i);
        Self { c: [p0, v0, a0 * 0.5, c3, c4, c5], h, end: p1 }
    }

    /// The same span with its last point replaced by one that differs by rounding only.
    #[must_use]
    pub(super) fn ending_at(self, end: Vector3<f64>) -> Self {
        Self { end, ..self }
    }

    /// Knot span `h`.
    #[must_use]
    pub fn knot_span(&self) -> f64 {
        self.h
    }

    /// First point \[m\].
    #[must_use]
    pub fn start(&self) -> Vector3<f64> {
        self.c[0]
    }

    /// Last point \[m\], exact.
    #[must_use]
    pub fn end(&self) -> Vector3<f64> {
        self.end
    }

    /// `S(u)` \[m\]; at and beyond `h` the exact last point.
    #[must_use]
    #[inline]
    pub fn position(&self, u: f64) -> Vector3<f64> {
        if u >= self.h {
            return self.end;
        }
        let c = &self.c;
        ((((c[5] * u + c[4]) * u + c[3]) * u + c[2]) * u + c[1]) * u + c[0]
    }

    /// `S'(u)`.
    #[must_use]
    #[inline]
    pub fn first(&self, u: f64) -> Vector3<f64> {
        let c = &self.c;
        (((c[5] * (5.0 * u) + c[4] * 4.0) * u + c[3] * 3.0) * u + c[2] * 2.0) * u + c[1]
    }

    /// `S''(u)`.
    #[must_use]
    #[inline]
    pub fn second(&self, u: f64) -> Vector3<f64> {
        let c = &self.c;
        ((c[5] * (20.0 * u) + c[4] * 12.0) * u + c[3] * 6.0) * u + c[2] * 2.0
    }

    /// `S'''(u)`.
    #[must_use]
    #[inline]
    pub fn third(&self, u: f64) -> Vector3<f64> {
        let c = &self.c;
        (c[5] * (60.0 * u) + c[4] * 24.0) * u + c[3] * 6.0
    }

    /// `S''''(u)`: zero for a cubic.
    #[must_use]
    #[inline]
    pub fn fourth(&self, u: f64) -> Vector3<f64> {
        self.c[5] * (120.0 * u) + self.c[4] * 24.0
    }

    /// Everything at `u` at once.
    #[must_use]
    pub fn at(&self, u: f64) -> SpanGeometry {
        SpanGeometry {
            position: self.position(u),
            first: self.first(u),
            second: self.second(u),
            third: self.third(u),
        }
    }
}

impl SpanGeometry {
    /// Unit tangent `T = S' / |S'|`; zero at a cusp.
    #[must_use]
    #[inline]
    pub fn tangent(&self) -> Vector3<f64> {
        self.first.try_normalize(0.0).unwrap_or_default()
    }

    /// Curvature `k = |S' x S''| / |S'|^3` [1/m]; infinite at a cusp.
    #[must_use]
    #[inline]
    pub fn curvature(&self) -> f64 {
        let speed = self.first.norm();
        let bend = self.first.cross(&self.second).norm();
        if speed > 0.0 { bend / (speed * speed * speed) } else { f64::INFINITY }
    }

    /// Derivatives of the position by the path length: `p_s = T`, `p_ss = k N` [1/m],
    /// `p_sss = k' N + k t B - k^2 T` [1/m^2].
    ///
    /// From `S' = w p_s`, `S'' = w^2 p_ss + w' p_s`, `S''' = w^3 p_sss + 3 w w' p_ss + w'' p_s` with `w = |S'|`.
    #[must_use]
    pub fn by_length(&self) -> [Vector3<f64>; 3] {
        let w = self.first.norm();
        let dw = self.first.dot(&self.second) / w;
        let ddw = (self.second.norm_squared() + self.first.dot(&self.third) - dw * dw) / w;
        let p1 = self.first / w;
        let p2 = (self.second - p1 * dw) / (w * w);
        let p3 = (self.third - p1 * ddw - p2 * (3.0 * w * dw)) / (w * w * w);
        [p1, p2, p3]
    }
}
