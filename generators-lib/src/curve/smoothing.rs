//! The smoothing spline: near the points, and little bent.
//!
//! `f` minimises `sum w_i |y_i - f(x_i)|^2 + lambda int |f''|^2`. With `g` its values and `c` its second derivatives at the
//! inner knots, `Q^T g = R c`; then `(R + lambda Q^T W^-1 Q) c = Q^T y` and `g = y - lambda W^-1 Q c`, and `f` is the natural
//! spline through `g` (Reinsch 1967; Green and Silverman, *Nonparametric Regression and Generalized Linear Models*, 2.3).

use mrroc::robot::JointVector;

use super::{CubicSpline, CurveError, SplineEnds};

impl<V: JointVector> CubicSpline<V> {
    /// The natural spline that minimises `sum weights |points - f|^2 + smoothing int |f''|^2` at rising `knots`, two or more:
    /// with no smoothing it passes the points, with endless smoothing it is the straight line of regression.
    ///
    /// # Errors
    /// As [`new`](Self::new); weights that are not positive, a smoothing that is negative.
    pub fn smoothing(
        knots: Vec<f64>,
        points: &[V],
        weights: &[f64],
        smoothing: f64,
    ) -> Result<Self, CurveError> {
        let n = knots.len();
        if n < 2 || points.len() != n || !knots.windows(2).all(|pair| pair[0] < pair[1]) {
            return Err(CurveError::Knots);
        }
        let right = |weight: &f64| *weight > 0.0 && weight.is_finite();
        if weights.len() != n || !weights.iter().all(right) || !(smoothing >= 0.0 && smoothing.is_finite()) {
            return Err(CurveError::Weights);
        }
        let h = |i: usize| knots[i + 1] - knots[i];
        // Row j of Q^T: what the inner knot j + 1 has of the values at j, j + 1, j + 2.
        let q = |j: usize| [1.0 / h(j), -1.0 / h(j) - 1.0 / h(j + 1), 1.0 / h(j + 1)];
        let inner = n - 2;
        let mut rows: Vec<[f64; 3]> = (0..inner)
            .map(|j| {
                let bend = [(h(j) + h(j + 1)) / 3.0, h(j + 1) / 6.0, 0.0];
                core::array::from_fn(|k| {
                    let shared = (k..3).map(|i| {
                        q(j)[i] * if j + k < inner { q(j + k)[i - k] } else { 0.0 } / weights[j + i]
                    });
                    bend[k] + smoothing * shared.sum::<f64>()
                })
            })
            .collect();
        let mut c: Vec<V> = (0..inner)
            .map(|j| points[j] * q(j)[0] + points[j + 1] * q(j)[1] + points[j + 2] * q(j)[2])
            .collect();
        solve(&mut rows, &mut c);
        let mut values = points.to_vec();
        for (j, c) in c.iter().enumerate() {
            for (i, q) in q(j).into_iter().enumerate() {
                values[j + i] = values[j + i] - *c * (smoothing * q / weights[j + i]);
            }
        }
        CubicSpline::new(knots, values, SplineEnds::Natural)
    }
}

/// Solves a symmetric positive definite system of five diagonals, given as the diagonal and the two above it, by `L D L^T`.
fn solve<V: JointVector>(rows: &mut [[f64; 3]], right: &mut [V]) {
    let n = rows.len();
    for i in 0..n {
        let [pivot, near, far] = rows[i];
        for (k, of_row) in [(1, near), (2, far)] {
            if i + k < n {
                let share = of_row / pivot;
                rows[i + k][0] -= share * of_row;
                if k == 1 && i + 1 < n {
                    rows[i + 1][1] -= share * far;
                }
                right[i + k] = right[i + k] - right[i] * share;
            }
        }
    }
    for i in (0..n).rev() {
        let mut sum = right[i];
        for k in 1..3 {
            if i + k < n {
                sum = sum - right[i + k] * rows[i][k];
            }
        }
        right[i] = sum * (1.0 / rows[i][0]);
    }
}
