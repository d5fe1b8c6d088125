//! Levenberg-Marquardt for dense problems of some hundred residuals and some tens of parameters.
//!
//! In: residuals of unit standard deviation, as a function of a point that small steps move (numbers, or poses: a manifold).
//! Out: the point where the sum of their losses is least. A step solves
//!
//! ```text
//! (J^T W J + lambda D^2) step = -J^T W r,     D: the largest norms of J's columns so far (More 1978),
//! ```
//!
//! with the weights `W` of the [`Loss`] and lambda by the ratio of gained to foretold decrease (Nielsen 1999). Normal equations are solved, and not
//! J's own factors: the residuals are computed anew after each step, which repairs what round-off spoils in it. What the solution is
//! worth, [`Information`](crate::Information) says from the factors themselves.

use nalgebra::{DMatrix, DVector};

use crate::loss::Loss;

/// A least-squares problem.
pub trait LeastSquares {
    /// A point: where the residuals are looked at.
    type At: Clone;

    /// Number of parameters, > 0.
    fn parameters(&self) -> usize;

    /// Number of residuals.
    fn residuals(&self) -> usize;

    /// The point that lies a small `step` (one number for each parameter) from `at`.
    fn moved(&self, at: &Self::At, step: &[f64]) -> Self::At;

    /// The residuals at a point, in units of their standard deviations.
    fn evaluate(&self, at: &Self::At, residuals: &mut [f64]);

    /// The residuals, and by column what a step of each parameter adds to them. By default by central differences of 1e-6.
    fn linearise(&self, at: &Self::At, residuals: &mut [f64], jacobian: &mut DMatrix<f64>) {
        const H: f64 = 1e-6;
        self.evaluate(at, residuals);
        let mut step = vec![0.0; self.parameters()];
        let mut back = vec![0.0; self.residuals()];
        for (i, mut column) in jacobian.column_iter_mut().enumerate() {
            step[i] = H;
            self.evaluate(&self.moved(at, &step), column.as_mut_slice());
            step[i] = -H;
            self.evaluate(&self.moved(at, &step), &mut back);
            step[i] = 0.0;
            for (ahead, back) in column.iter_mut().zip(&back) {
                *ahead = (*ahead - back) / (2.0 * H);
            }
        }
    }
}

/// When the iteration ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// How residuals count.
    pub loss: Loss,
    /// Most linearisations, > 0.
    pub iterations: usize,
    /// It has converged where a step would lower the cost by less than this part of it, 0 to 1.
    pub tolerance: f64,
}

impl Default for Settings {
    fn default() -> Self {
        Self { loss: Loss::Squares, iterations: 100, tolerance: 1e-14 }
    }
}

/// Where the iteration has ended.
#[derive(Clone, Debug)]
pub struct Minimum<A> {
    /// The point.
    pub at: A,
    /// Half the sum of the losses there.
    pub cost: f64,
    /// The residuals there, unweighted.
    pub residuals: DVector<f64>,
    /// Their derivatives, unweighted: a column for each parameter.
    pub jacobian: DMatrix<f64>,
    /// How often the problem was linearised.
    pub iterations: usize,
}

/// Why there is no minimum.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum NoMinimum {
    /// A residual is not finite at the start.
    #[error(
        "residual {index} is {value} at the start of the iteration: start nearer, or leave that measurement out"
    )]
    NotFinite {
        /// Which one, from 0.
        index: usize,
        /// Its value.
        value: f64,
    },
    /// The iteration has not converged: it began too far away, or what is measured tells too little of a parameter without a tolerance.
    #[error("no minimum after {iterations} iterations, cost {cost:.3e}")]
    NotConverged {
        /// How many there were.
        iterations: usize,
        /// The cost at the end.
        cost: f64,
    },
}

/// Where the damping starts, as a part of the squared norms of the columns.
const FIRST_DAMPING: f64 = 1e-9;

/// Residuals are 0 where the mean of their squares is below this: what is left then is round-off, which steps might lower for ever.
const EXACT: f64 = 1e-24;

/// A damping above which steps are no steps.
const STUCK: f64 = 1e12;

/// The least sum of losses near `start`.
///
/// ```
/// use mrroc_calibration::{LeastSquares, Settings, minimise};
///
/// /// The point of the parabola y = x^2 that is nearest to (0, 1): x^2 = 1/2.
/// struct Nearest;
/// impl LeastSquares for Nearest {
///     type At = f64;
///     fn parameters(&self) -> usize { 1 }
///     fn residuals(&self) -> usize { 2 }
///     fn moved(&self, at: &f64, step: &[f64]) -> f64 { at + step[0] }
///     fn evaluate(&self, at: &f64, residuals: &mut [f64]) {
///         residuals.copy_from_slice(&[*at, at * at - 1.0]);
///     }
/// }
/// let minimum = minimise(&Nearest, 2.0, &Settings::default())?;
/// assert!((minimum.at - 0.5_f64.sqrt()).abs() < 1e-7);
/// # Ok::<(), mrroc_calibration::NoMinimum>(())
/// ```
///
/// # Errors
/// [`NoMinimum`].
pub fn minimise<P: LeastSquares>(
    problem: &P,
    start: P::At,
    settings: &Settings,
) -> Result<Minimum<P::At>, NoMinimum> {
    let (m, n) = (problem.residuals(), problem.parameters());
    let mut at = start;
    let mut residuals = DVector::zeros(m);
    let mut jacobian = DMatrix::zeros(m, n);
    let mut weighted = DMatrix::zeros(m, n);
    let mut ahead = DVector::zeros(m);
    let mut norms: DVector<f64> = DVector::zeros(n);
    let (mut damping, mut growth) = (FIRST_DAMPING, 2.0);
    let mut cost = f64::INFINITY;
    for iteration in 1..=settings.iterations {
        problem.linearise(&at, residuals.as_mut_slice(), &mut jacobian);
        if iteration == 1 {
            if let Some((index, value)) = residuals.iter().enumerate().find(|(_, r)| !r.is_finite()) {
                return Err(NoMinimum::NotFinite { index, value: *value });
            }
            cost = settings.loss.cost(residuals.as_slice());
        }
        let end =
            |at, cost, residuals, jacobian| Minimum { at, cost, residuals, jacobian, iterations: iteration };
        if cost <= EXACT * m as f64 {
            return Ok(end(at, cost, residuals, jacobian));
        }
        let gradient = weigh(settings.loss, &residuals, &jacobian, &mut weighted);
        let normal = squared(&weighted);
        for (norm, square) in norms.iter_mut().zip(normal.diagonal().iter()) {
            *norm = norm.max(square.sqrt());
        }
        loop {
            let Some((step, foretold)) = step(&normal, &gradient, &norms, damping) else {
                damping *= growth;
                growth *= 2.0;
                if damping > STUCK {
                    return Err(NoMinimum::NotConverged { iterations: iteration, cost });
                }
                continue;
            };
            if foretold <= settings.tolerance * cost {
                return Ok(end(at, cost, residuals, jacobian));
            }
            let there = problem.moved(&at, step.as_slice());
            problem.evaluate(&there, ahead.as_mut_slice());
            let cost_there = settings.loss.cost(ahead.as_slice());
            let ratio = (cost - cost_there) / foretold;
            if ratio > 0.0 {
                damping *= (1.0 - (2.0 * ratio - 1.0).powi(3)).max(1.0 / 3.0);
                growth = 2.0;
                (at, cost) = (there, cost_there);
                break;
            }
            damping *= growth;
            growth *= 2.0;
            // No step, however short, lowers the cost: round-off is all that is left of the gradient.
            if damping > STUCK {
                return Ok(end(at, cost, residuals, jacobian));
            }
        }
    }
    Err(NoMinimum::NotConverged { iterations: settings.iterations, cost })
}

/// Writes the jacobian by the weights of the loss, and returns the gradient of the cost.
fn weigh(
    loss: Loss,
    residuals: &DVector<f64>,
    jacobian: &DMatrix<f64>,
    weighted: &mut DMatrix<f64>,
) -> DVector<f64> {
    let roots = residuals.map(|r| loss.weight(r).sqrt());
    weighted.copy_from(jacobian);
    for mut column in weighted.column_iter_mut() {
        column.component_mul_assign(&roots);
    }
    weighted.tr_mul(&residuals.component_mul(&roots))
}

/// `A^T A`, of which only half is computed.
fn squared(of: &DMatrix<f64>) -> DMatrix<f64> {
    let n = of.ncols();
    let mut square = DMatrix::zeros(n, n);
    for i in 0..n {
        for j in 0..=i {
            let dot = of.column(i).dot(&of.column(j));
            square[(i, j)] = dot;
            square[(j, i)] = dot;
        }
    }
    square
}

/// The damped step, and by how much it would lower the cost if the residuals were linear; `None` if the damping is too small.
fn step(
    normal: &DMatrix<f64>,
    gradient: &DVector<f64>,
    norms: &DVector<f64>,
    damping: f64,
) -> Option<(DVector<f64>, f64)> {
    let mut damped = normal.clone();
    for (i, norm) in norms.iter().enumerate() {
        // A parameter that nothing depends on stays where it is.
        damped[(i, i)] += if *norm > 0.0 { damping * norm * norm } else { 1.0 };
    }
    let step = -damped.cholesky()?.solve(gradient);
    let foretold = -gradient.dot(&step) - 0.5 * step.dot(&(normal * &step));
    (foretold.is_finite() && foretold >= 0.0).then_some((step, foretold))
}
