//! The spline through orientations, twice continuously differentiable: angular velocity and acceleration do not jump.
//!
//! On span `i`, `h` long, `R = R_i Exp(f)` with a cubic rotation vector `f` from 0 to `F_i = Log(R_i^T R_i+1)`, whose slopes at the ends are
//! `w_i` and `J(F_i)^-1 w_i+1`, `w` the angular velocities in the moving frame at the knots, `J` the right Jacobian. The angular
//! acceleration is `a = J f'' + n(f, f')`; that it be the same on both sides of a knot makes
//!
//! ```text
//! 2 J_i-1 w_i-1 / h_i-1 + 4 (1 / h_i-1 + 1 / h_i) w_i + 2 J_i^-1 w_i+1 / h_i = 6 F_i-1 / h_i-1^2 + 6 F_i / h_i^2 - n_i-1
//! ```
//!
//! solved by blocks for given `n`, and repeated with the `n` of the solution. At the first and the last knot the angular
//! velocity is that of the span's own turn. The same as scipy's `RotationSpline` (Park and Ravani, *Smooth Invariant Interpolation of
//! Rotations*, 1997).

use nalgebra::{Matrix3, UnitQuaternion, Vector3};

use super::CurveError;

/// Repetitions, and the change of an angular velocity, as a share of it, at which they end.
const REPETITIONS: usize = 200;
const SETTLED: f64 = 1e-14;

/// An orientation, by a parameter: a polynomial of the rotation vector between knots.
#[derive(Clone, Debug, PartialEq)]
pub struct RotationSpline {
    knots: Vec<f64>,
    orientations: Vec<UnitQuaternion<f64>>,
    /// Coefficients of the parameter's first to third power.
    spans: Vec<[Vector3<f64>; 3]>,
}

/// `(1 - cos x) / x^2`, `(x - sin x) / x^3`, and the derivatives of both by `x^2 / 2`.
fn coefficients(x: f64) -> [f64; 4] {
    let y = x * x;
    if x < 0.4 {
        // `1 - y / a (1 - y / b (..))`; the next terms are below 1e-16.
        let series = |next: [f64; 5]| next.iter().rev().fold(1.0, |rest, divisor| 1.0 - y / divisor * rest);
        return [
            series([12.0, 30.0, 56.0, 90.0, 132.0]) / 2.0,
            series([20.0, 42.0, 72.0, 110.0, 156.0]) / 6.0,
            series([15.0, 112.0 / 3.0, 67.5, 105.6, 151.666_666_666_666_66]) / -12.0,
            series([21.0, 48.0, 82.5, 124.8, 175.0]) / -60.0,
        ];
    }
    let (s, c) = x.sin_cos();
    [
        (1.0 - c) / y,
        (x - s) / (y * x),
        (x * s + 2.0 * (c - 1.0)) / (y * y),
        (3.0 * s - x * c - 2.0 * x) / (y * y * x),
    ]
}

/// The right Jacobian at the rotation vector `f`: `w = J f'` in the moving frame.
fn jacobian(f: &Vector3<f64>) -> Matrix3<f64> {
    let [b, c, ..] = coefficients(f.norm());
    let cross = f.cross_matrix();
    Matrix3::identity() - cross * b + cross * cross * c
}

/// The part of the angular acceleration that depends on the rotation vector's slope alone: `(dJ/dt) f'`.
fn rest(f: &Vector3<f64>, slope: &Vector3<f64>) -> Vector3<f64> {
    let [_, c, db, dc] = coefficients(f.norm());
    let along = f.dot(slope);
    let turn = f.cross(slope);
    (f.cross(&turn) * dc - turn * db) * along + slope.cross(&turn) * c
}

impl RotationSpline {
    /// Through `orientations` at rising `knots`, two or more, each time through the smaller angle.
    ///
    /// # Errors
    /// Knots that do not rise or do not match; numbers that are not finite; turns so large that the angular velocities
    /// settle at none.
    pub fn new(knots: Vec<f64>, orientations: Vec<UnitQuaternion<f64>>) -> Result<Self, CurveError> {
        let n = knots.len();
        if n < 2 || orientations.len() != n || !knots.windows(2).all(|pair| pair[0] < pair[1]) {
            return Err(CurveError::Knots);
        }
        let finite = |q: &UnitQuaternion<f64>| q.coords.iter().all(|x| x.is_finite());
        if !(knots.iter().all(|x| x.is_finite()) && orientations.iter().all(finite)) {
            return Err(CurveError::NotFinite);
        }
        let h: Vec<_> = knots.windows(2).map(|pair| pair[1] - pair[0]).collect();
        let turns: Vec<_> = orientations.windows(2).map(|q| (q[0].inverse() * q[1]).scaled_axis()).collect();
        let jacobians: Vec<_> = turns.iter().map(jacobian).collect();
        let inverses = jacobians.iter().map(|j| j.try_inverse().ok_or(CurveError::Turn));
        let inverses = inverses.collect::<Result<Vec<_>, _>>()?;
        let rates = rates(&h, &turns, &jacobians, &inverses)?;
        let spans = (0..n - 1).map(|i| {
            let slope = rates[i];
            let end = inverses[i] * rates[i + 1];
            let f = turns[i];
            let h = h[i];
            let second = (f * 3.0 - slope * (2.0 * h) - end * h) / (h * h);
            [slope, second, (slope * h + end * h - f * 2.0) / (h * h * h)]
        });
        let spans: Vec<[Vector3<f64>; 3]> = spans.collect();
        if spans.iter().flatten().any(|c| !c.iter().all(|x| x.is_finite())) {
            return Err(CurveError::NotFinite);
        }
        Ok(RotationSpline { knots, orientations, spans })
    }

    /// The orientation at `u`, and angular velocity and acceleration in the moving frame \[rad\], by the parameter; beyond its
    /// ends it stays there.
    #[must_use]
    pub fn at(&self, u: f64) -> (UnitQuaternion<f64>, Vector3<f64>, Vector3<f64>) {
        let last = self.spans.len() - 1;
        let i = self.knots.partition_point(|knot| *knot <= u).saturating_sub(1).min(last);
        let from = self.knots[i];
        let to = self.knots[i + 1];
        let x = u.clamp(from, to) - from;
        let [a, b, c] = self.spans[i];
        let f = (a + (b + c * x) * x) * x;
        let slope = a + (b * 2.0 + c * (3.0 * x)) * x;
        let bend = b * 2.0 + c * (6.0 * x);
        let j = jacobian(&f);
        let end = x == to - from;
        let orientation = if end {
            self.orientations[i + 1]
        } else {
            self.orientations[i] * UnitQuaternion::from_scaled_axis(f)
        };
        (orientation, j * slope, j * bend + rest(&f, &slope))
    }

    /// Bounds of the angular velocity and acceleration \[rad\] by the parameter: the hull of the rotation vector's slope, since
    /// `J` lengthens nothing; its second derivative, and at most `w^2 (x / 6 + x^2 / 12 + x^3 / 60)` at an angle `x`.
    #[must_use]
    pub fn bounds(&self) -> (f64, f64) {
        let mut velocity = 0.0_f64;
        let mut acceleration = 0.0_f64;
        for (span, pair) in self.spans.iter().zip(self.knots.windows(2)) {
            let [a, b, c] = *span;
            let h = pair[1] - pair[0];
            // Bernstein coefficients of slope and vector.
            let slopes = [a, a + b * h, a + b * (2.0 * h) + c * (3.0 * h * h)];
            let vectors = [a * (h / 3.0), (a * 2.0 + b * h) * (h / 3.0), (a + (b + c * h) * h) * h];
            let most = |all: [Vector3<f64>; 3]| all.iter().map(|v| v.norm()).fold(0.0, f64::max);
            let w = most(slopes);
            let x = most(vectors);
            let bend = (b * 2.0).norm().max((b * 2.0 + c * (6.0 * h)).norm());
            velocity = velocity.max(w);
            acceleration = acceleration.max(bend + w * w * x * (1.0 / 6.0 + x * (1.0 / 12.0 + x / 60.0)));
        }
        (velocity, acceleration)
    }
}

/// Angular velocities at the knots.
fn rates(
    h: &[f64],
    turns: &[Vector3<f64>],
    jacobians: &[Matrix3<f64>],
    inverses: &[Matrix3<f64>],
) -> Result<Vec<Vector3<f64>>, CurveError> {
    let n = turns.len();
    let mut rates: Vec<_> = (0..=n).map(|i| turns[i.min(n - 1)] / h[i.min(n - 1)]).collect();
    if n == 1 {
        return Ok(rates);
    }
    for _ in 0..REPETITIONS {
        // Thomas' algorithm with blocks: of each row, what the knot behind adds, and the right-hand side.
        let mut behind = vec![Matrix3::zeros(); n];
        let mut right = vec![rates[0]; n];
        for i in 1..n {
            let slope = inverses[i - 1] * rates[i];
            let before = jacobians[i - 1] * (2.0 / h[i - 1]);
            let own = 4.0 * (1.0 / h[i - 1] + 1.0 / h[i]);
            let known = turns[i - 1] * (6.0 / (h[i - 1] * h[i - 1])) + turns[i] * (6.0 / (h[i] * h[i]))
                - rest(&turns[i - 1], &slope);
            let pivot = Matrix3::from_diagonal_element(own) - before * behind[i - 1];
            let pivot = pivot.try_inverse().ok_or(CurveError::Turn)?;
            behind[i] = pivot * inverses[i] * (2.0 / h[i]);
            right[i] = pivot * (known - before * right[i - 1]);
        }
        let mut change = 0.0_f64;
        for i in (1..n).rev() {
            let rate = right[i] - behind[i] * rates[i + 1];
            change = change.max((rate - rates[i]).norm() / (1.0 + rate.norm()));
            rates[i] = rate;
        }
        if change <= SETTLED {
            return Ok(rates);
        }
        if !change.is_finite() {
            break;
        }
    }
    Err(CurveError::Turn)
}
