//! Rational B-splines (NURBS): `C(u) = sum w_i P_i N_i(u) / sum w_i N_i(u)`.
//!
//! Evaluated by de Boor's recursion on `(w P, w)`, its derivatives on the differences of the control points; those of the
//! quotient by `C' = (A' - w' C) / w`, `C'' = (A'' - 2 w' C' - w'' C) / w`. Literature: Piegl and Tiller, *The NURBS Book*,
//! chapters 2 to 4. Circles and ellipses are exact.

use nalgebra::{Vector3, Vector4};

use super::{CurveError, Parametric, SplinePoint, finite};

/// The highest degree.
const MOST: usize = 7;

/// A rational B-spline in space, by its parameter; [`ByLength`](super::ByLength) makes a curve of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Nurbs {
    degree: usize,
    /// `(w P, w)`.
    control: Vec<Vector4<f64>>,
    /// All knots, and the distinct ones within the range.
    all_knots: Vec<f64>,
    breaks: Vec<f64>,
}

impl Nurbs {
    /// Of `degree` 1 to 7, with a weight > 0 per control point \[m\], of which there are more than the degree, and
    /// `knots`, degree + 1 more than points, that do not fall; an inner knot occurs at most `degree - 1` times where the
    /// tangent is to be continuous.
    ///
    /// # Errors
    /// Knots, weights or points that are out of range, or not as many as belong together.
    pub fn new(
        degree: usize,
        points: &[Vector3<f64>],
        weights: &[f64],
        knots: Vec<f64>,
    ) -> Result<Self, CurveError> {
        finite(points)?;
        let right = |weight: &f64| *weight > 0.0 && weight.is_finite();
        if weights.len() != points.len() || !weights.iter().all(right) {
            return Err(CurveError::Weights);
        }
        let n = points.len();
        let p = degree;
        let matched = (1..=MOST).contains(&p) && n > p && knots.len() == n + p + 1;
        if !matched || !knots.iter().all(|knot| knot.is_finite()) || !knots.is_sorted() {
            return Err(CurveError::Knots);
        }
        let mut breaks = knots[p..=n].to_vec();
        breaks.dedup();
        // An inner knot that occurs more often than the degree tears the curve.
        let torn = knots[1..n + p].windows(p + 1).any(|knots| knots[0] == knots[p]);
        if breaks.len() < 2 || torn {
            return Err(CurveError::Knots);
        }
        let control: Vec<_> = points.iter().zip(weights).map(|(p, w)| (p * *w).push(*w)).collect();
        if !control.iter().all(|point| point.iter().all(|x| x.is_finite())) {
            return Err(CurveError::NotFinite);
        }
        Ok(Nurbs { degree, control, all_knots: knots, breaks })
    }

    /// The full circle of `radius` \[m\] about `centre` from the direction `x` towards `y`, two unit vectors at right angles:
    /// four quadratic pieces.
    ///
    /// # Errors
    /// A number that is not finite, a radius that is not positive.
    pub fn circle(
        centre: Vector3<f64>,
        x: Vector3<f64>,
        y: Vector3<f64>,
        radius: f64,
    ) -> Result<Self, CurveError> {
        // Not a number is refused with the points.
        if radius <= 0.0 {
            return Err(CurveError::Coincident);
        }
        let corners = [(1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1), (1, 0)];
        let points = corners.map(|(i, j)| centre + (x * f64::from(i) + y * f64::from(j)) * radius);
        let weights: Vec<_> = (0..9).map(|i| if i % 2 == 0 { 1.0 } else { 0.5_f64.sqrt() }).collect();
        let knots = [0, 0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 4].map(f64::from).to_vec();
        Nurbs::new(2, &points, &weights, knots)
    }

    /// De Boor's recursion: the B-spline of `degree` whose control points on the span are `points`.
    fn de_boor(&self, points: &mut [Vector4<f64>], degree: usize, span: usize, u: f64) -> Vector4<f64> {
        for r in 1..=degree {
            for i in (r..=degree).rev() {
                let low = self.all_knots[span - degree + i];
                let high = self.all_knots[span + i + 1 - r];
                let share = (u - low) / (high - low);
                points[i] = points[i - 1] + (points[i] - points[i - 1]) * share;
            }
        }
        points[degree]
    }
}

impl Parametric for Nurbs {
    type Value = Vector3<f64>;

    fn range(&self) -> (f64, f64) {
        (self.breaks[0], self.breaks[self.breaks.len() - 1])
    }

    fn knots(&self) -> &[f64] {
        &self.breaks
    }

    fn at(&self, u: f64) -> SplinePoint<Vector3<f64>> {
        let (p, (first, last)) = (self.degree, self.range());
        let u = u.clamp(first, last);
        // The span that begins at or before `u`; the last one at the end.
        let after = self.all_knots.partition_point(|knot| *knot <= u);
        let span =
            if u == last { self.all_knots.partition_point(|knot| *knot < last) - 1 } else { after - 1 };
        let mut points = [Vector4::zeros(); MOST + 1];
        points[..=p].copy_from_slice(&self.control[span - p..=span]);
        // Control points of the derivatives, each one degree lower.
        let mut derivative = points;
        let mut values = [self.de_boor(&mut points, p, span, u), Vector4::zeros(), Vector4::zeros()];
        for (k, value) in values.iter_mut().enumerate().skip(1).take(p.min(2)) {
            let degree = p + 1 - k;
            for i in 0..degree {
                let low = self.all_knots[span - degree + 1 + i];
                let high = self.all_knots[span + 1 + i];
                derivative[i] = (derivative[i + 1] - derivative[i]) * (degree as f64 / (high - low));
            }
            let mut points = derivative;
            *value = self.de_boor(&mut points, degree - 1, span, u);
        }
        let [(a, w), (a1, w1), (a2, w2)] = values.map(|v| (v.xyz(), v.w));
        let value = a / w;
        let slope = (a1 - value * w1) / w;
        SplinePoint { value, first: slope, second: (a2 - slope * (2.0 * w1) - value * w2) / w }
    }
}
