//! The cubic spline through vectors at knots: natural, or with given slopes at its ends.
//!
//! With `h_i` the knot spans and `D_i` the slopes of the chords, the slopes `m_i` at the knots satisfy
//! `h_i m_{i-1} + 2 (h_{i-1} + h_i) m_i + h_{i-1} m_{i+1} = 3 (h_i D_{i-1} + h_{i-1} D_i)`; at a natural end
//! `2 m_0 + m_1 = 3 D_0` (de Boor, *A Practical Guide to Splines*, chapter IV).

use mrroc::robot::JointVector;

use super::CurveError;
use crate::waypoints;

/// What holds at the ends of a spline.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SplineEnds<V> {
    /// No second derivative.
    Natural,
    /// These first derivatives at the first and the last knot.
    Clamped(V, V),
}

/// A spline at one value of its parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SplinePoint<V> {
    /// Its value.
    pub value: V,
    /// First derivative by the parameter.
    pub first: V,
    /// Second derivative.
    pub second: V,
}

/// A cubic spline of vectors, twice continuously differentiable.
#[derive(Clone, Debug, PartialEq)]
pub struct CubicSpline<V> {
    knots: Vec<f64>,
    points: Vec<V>,
    slopes: Vec<V>,
}

impl<V: JointVector> CubicSpline<V> {
    /// Through `points` at rising `knots`, two or more.
    ///
    /// # Errors
    /// Knots that do not rise or do not match the points; a number that is not finite.
    pub fn new(knots: Vec<f64>, points: Vec<V>, ends: SplineEnds<V>) -> Result<Self, CurveError> {
        let n = knots.len();
        if n < 2 || points.len() != n || !knots.windows(2).all(|pair| pair[0] < pair[1]) {
            return Err(CurveError::Knots);
        }
        if !(knots.iter().all(|x| x.is_finite()) && points.iter().all(V::is_finite)) {
            return Err(CurveError::NotFinite);
        }
        let h = |i: usize| knots[i + 1] - knots[i];
        let chord = |i: usize| (points[i + 1] - points[i]) * (1.0 / h(i));
        // Rows: coefficients of the slope before, of its own and of the slope behind, and the right-hand side.
        let row = |i: usize| match ends {
            SplineEnds::Clamped(first, _) if i == 0 => (0.0, 1.0, 0.0, first),
            SplineEnds::Clamped(_, last) if i == n - 1 => (0.0, 1.0, 0.0, last),
            SplineEnds::Natural if i == 0 => (0.0, 2.0, 1.0, chord(0) * 3.0),
            SplineEnds::Natural if i == n - 1 => (1.0, 2.0, 0.0, chord(n - 2) * 3.0),
            _ => (h(i), 2.0 * (h(i - 1) + h(i)), h(i - 1), (chord(i - 1) * h(i) + chord(i) * h(i - 1)) * 3.0),
        };
        // Thomas' algorithm; the rows are diagonally dominant.
        let mut above = vec![0.0; n];
        let mut slopes = vec![V::zeros(); n];
        for i in 0..n {
            let (before, own, behind, right) = row(i);
            let (c, m) = if i == 0 { (0.0, V::zeros()) } else { (above[i - 1], slopes[i - 1]) };
            let pivot = 1.0 / (own - before * c);
            above[i] = behind * pivot;
            slopes[i] = (right - m * before) * pivot;
        }
        for i in (0..n - 1).rev() {
            slopes[i] = slopes[i] - slopes[i + 1] * above[i];
        }
        if !slopes.iter().all(V::is_finite) {
            return Err(CurveError::NotFinite);
        }
        Ok(CubicSpline { knots, points, slopes })
    }

    /// The natural spline through `points` [rad or m] that count by the rule of [`waypoints`], at knots by their distances.
    ///
    /// # Errors
    /// [`CurveError::Points`]: a number that is not finite, or no two points that are apart.
    pub fn by_chords(points: &[V]) -> Result<Self, CurveError> {
        let points = waypoints::joints(points)?;
        CubicSpline::new(waypoints::knots(&points, waypoints::chord), points, SplineEnds::Natural)
    }

    /// The knots.
    #[must_use]
    pub fn knots(&self) -> &[f64] {
        &self.knots
    }

    /// The first and the last knot.
    #[must_use]
    pub fn range(&self) -> (f64, f64) {
        (self.knots[0], self.knots[self.knots.len() - 1])
    }

    /// The spline at `u`; beyond its ends it stays there. At its last knot it is exactly at its last point.
    #[must_use]
    pub fn at(&self, u: f64) -> SplinePoint<V> {
        let last = self.knots.len() - 2;
        let i = self.knots.partition_point(|knot| *knot <= u).saturating_sub(1).min(last);
        let from = self.knots[i];
        let to = self.knots[i + 1];
        let h = to - from;
        let u = u.clamp(from, to) - from;
        let m = self.slopes[i];
        let n = self.slopes[i + 1];
        let chord = (self.points[i + 1] - self.points[i]) * (1.0 / h);
        let c2 = (chord * 3.0 - m * 2.0 - n) * (1.0 / h);
        let c3 = (m + n - chord * 2.0) * (1.0 / (h * h));
        let value = if u == h { self.points[i + 1] } else { self.points[i] + (m + (c2 + c3 * u) * u) * u };
        SplinePoint { value, first: m + (c2 * 2.0 + c3 * (3.0 * u)) * u, second: c2 * 2.0 + c3 * (6.0 * u) }
    }

    /// The largest magnitude of each component's first and second derivative, exact: the second is linear between
    /// knots, the first is largest at a knot or where the second passes zero.
    #[must_use]
    pub fn peaks(&self) -> (V, V) {
        let mut first = V::zeros();
        let mut second = V::zeros();
        for pair in self.knots.windows(2) {
            let from = self.at(pair[0]);
            let to = self.at(pair[1].next_down());
            for i in 0..V::LEN {
                first[i] = first[i].max(from.first[i].abs()).max(to.first[i].abs());
                second[i] = second[i].max(from.second[i].abs()).max(to.second[i].abs());
                let share = from.second[i] / (from.second[i] - to.second[i]);
                if share > 0.0 && share < 1.0 {
                    first[i] = first[i].max(self.at(pair[0] + (pair[1] - pair[0]) * share).first[i].abs());
                }
            }
        }
        (first, second)
    }
}
