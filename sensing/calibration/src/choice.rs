//! Which postures to measure: of many that could be, the few after which the least is left unsure.
//!
//! In: a problem with all candidates' measurements as they are expected, and aims: places that are to be foretold well, bases that are to be
//! found. Out: the candidates to measure, best first. With `A` the information of what is measured in any case and of tolerances, `J_c`
//! the Jacobian of candidate c and `L` the aims' derivatives, the candidates are taken one by one, so that the variance left is least:
//!
//! ```text
//! C = A^-1,   tr(L C L^T) sinks by   tr((1 + J_c C J_c^T)^-1 J_c C L^T L C J_c^T)      (Woodbury)
//! ```
//!
//! What a candidate gains hardly ever grows while others are taken, so that only those need be looked at again that once gained more than
//! the best one does now (Minoux 1978).

use nalgebra::{DMatrix, DVector};

use crate::equations::Equations;
use crate::information::Information;
use crate::least_squares::LeastSquares;
use crate::parameter::Unit;
use crate::problem::{ArmId, FrameId, Posture, Problem, Slot, TargetId};

/// What is to be known well.
#[derive(Clone, Debug, PartialEq)]
pub enum Aim {
    /// Where a target on an arm is, with the arm at these joint positions [rad or m].
    Place(ArmId, Vec<f64>, TargetId),
    /// Where one frame of the world is in another, its orientation counted at 1 m.
    Between(FrameId, FrameId),
}

/// What was chosen.
#[derive(Clone, Debug, PartialEq)]
pub struct Choice {
    /// The candidates, from the one that was taken first.
    pub candidates: Vec<usize>,
    /// After each the root mean square of the aims' standard deviations that is left \[m\].
    pub left: Vec<f64>,
    /// The smallest singular value of the Jacobian of what is measured and believed, with columns of norm 1.
    pub smallest: f64,
}

/// What is believed at least of what has no tolerance: that it is within a decimetre, 0.1 rad, 100 pixels, 1 %.
fn believed(unit: Unit) -> f64 {
    match unit {
        Unit::Metre | Unit::Radian => 0.1,
        Unit::Pixel => 100.0,
        Unit::One => 0.01,
        Unit::RadianPerNewtonMetre => 1e-4,
    }
}

/// Chooses `count` of the candidates, each a list of measurements of `problem` from 0; measurements in none of them are made in any case.
///
/// The problem is looked at where everything is believed to be. Candidates that are not attainable, not in sight or not clear must not
/// be among them. Fewer are chosen if there are fewer.
#[must_use]
pub fn choose(problem: &Problem, candidates: &[Vec<usize>], aims: &[Aim], count: usize) -> Choice {
    Chooser::new(problem, candidates, aims).choose(count)
}

/// How sure the aims are after measuring `chosen` of the candidates: the same figures as of a choice.
#[must_use]
pub fn evaluate(problem: &Problem, candidates: &[Vec<usize>], aims: &[Aim], chosen: &[usize]) -> Choice {
    Chooser::new(problem, candidates, aims).told(chosen.to_vec())
}

/// What all candidates together tell something of; of the rest each is left where it is believed to be, as in a fit.
fn seen(problem: &Problem) -> Vec<Slot> {
    let at = problem.start();
    let slots = problem.slots();
    let sigma = problem.instruments.iter().map(|one| one.noise.sigma().to_vec()).collect();
    let all = (0..problem.measurements()).collect();
    let equations = Equations::new(problem, slots.clone(), all, sigma);
    let mut residuals = DVector::zeros(equations.residuals());
    let mut jacobian = DMatrix::zeros(equations.residuals(), slots.len());
    equations.linearise(&at, residuals.as_mut_slice(), &mut jacobian);
    let importance: Vec<u8> = slots.iter().map(|slot| problem.parameter(*slot).importance).collect();
    let measured = jacobian.rows(0, equations.measured()).into_owned();
    let unseen = Information::of(&measured, &importance).unseen;
    let left = slots.iter().enumerate().filter(|(i, _)| unseen.iter().all(|one| one.fixed != *i));
    left.map(|(_, slot)| *slot).collect()
}

struct Chooser {
    /// The information of what is measured in any case.
    before: DMatrix<f64>,
    /// By candidate its rows of the Jacobian.
    rows: Vec<DMatrix<f64>>,
    /// L^T L, by how many aims there are.
    aims: DMatrix<f64>,
}

impl Chooser {
    fn new(problem: &Problem, candidates: &[Vec<usize>], aims: &[Aim]) -> Self {
        let at = problem.start();
        let slots = seen(problem);
        let sigma: Vec<Vec<f64>> = problem.instruments.iter().map(|one| one.noise.sigma().to_vec()).collect();
        let of = |used: Vec<usize>| Equations::new(problem, slots.clone(), used, sigma.clone()).whitened(&at);
        let jacobian = |equations: &Equations<'_>| {
            let mut residuals = DVector::zeros(equations.residuals());
            let mut jacobian = DMatrix::zeros(equations.residuals(), slots.len());
            equations.linearise(&at, residuals.as_mut_slice(), &mut jacobian);
            jacobian
        };
        let mut in_any_case = vec![true; problem.measurements()];
        candidates.iter().flatten().for_each(|i| in_any_case[*i] = false);
        let used = (0..problem.measurements()).filter(|i| in_any_case[*i]).collect();
        let own = jacobian(&of(used));
        let mut before = own.tr_mul(&own);
        for (i, slot) in slots.iter().enumerate() {
            let parameter = problem.parameter(*slot);
            if parameter.tolerance.is_none() {
                before[(i, i)] += believed(parameter.unit).powi(-2);
            }
        }
        let rows = candidates.iter().map(|used| {
            let mut used = used.clone();
            used.sort_unstable();
            let equations = of(used);
            // Bars and tolerances stand behind what is measured, and are counted already.
            let measured = equations.measured() - problem.bars.len();
            jacobian(&equations).rows(0, measured).into_owned()
        });
        let rows = rows.collect();
        let equations = of(Vec::new());
        let mut square = DMatrix::zeros(slots.len(), slots.len());
        for aim in aims {
            let (twists, height) = match aim {
                Aim::Place(arm, q, target) => {
                    let posture = Posture { arm: *arm, q: q.clone(), torques: Vec::new() };
                    let flange = equations.flange(&at, &posture, true);
                    let frame = problem.targets[target.0].frame;
                    (equations.mounted(&at, Some(&flange), frame, true).twists, 3)
                }
                Aim::Between(from, to) => (equations.apart(&at, *from, *to).1, 6),
            };
            let mut by_column = DMatrix::zeros(height, slots.len());
            for (column, twist) in &twists {
                let mut sum = by_column.column_mut(*column);
                sum += twist.rows(0, height);
            }
            square += by_column.tr_mul(&by_column);
        }
        Self { before, rows, aims: square / aims.len().max(1) as f64 }
    }

    fn choose(&self, count: usize) -> Choice {
        let mut chosen = Vec::new();
        let mut information = self.before.clone();
        // What each gained when it was last looked at.
        let mut gains = vec![f64::INFINITY; self.rows.len()];
        while chosen.len() < count.min(self.rows.len()) {
            let Some(covariance) = inverse(&information) else { break };
            let weighted = &covariance * &self.aims * &covariance;
            let mut order: Vec<usize> = (0..self.rows.len()).filter(|i| !chosen.contains(i)).collect();
            order.sort_by(|a, b| gains[*b].total_cmp(&gains[*a]));
            let mut best: Option<(f64, usize)> = None;
            for i in order {
                if best.is_some_and(|(most, _)| gains[i] < most) {
                    break;
                }
                gains[i] = gain(&self.rows[i], &covariance, &weighted);
                if best.is_none_or(|(most, _)| gains[i] > most) {
                    best = Some((gains[i], i));
                }
            }
            let Some((_, taken)) = best else { break };
            information += self.rows[taken].tr_mul(&self.rows[taken]);
            chosen.push(taken);
        }
        self.told(chosen)
    }

    fn told(&self, candidates: Vec<usize>) -> Choice {
        let mut information = self.before.clone();
        let mut left = Vec::new();
        for i in &candidates {
            information += self.rows[*i].tr_mul(&self.rows[*i]);
            let variance = inverse(&information).map(|covariance| (covariance * &self.aims).trace());
            left.push(variance.map_or(f64::INFINITY, |variance| variance.max(0.0).sqrt()));
        }
        let norms = information.diagonal().map(|square| if square > 0.0 { square.sqrt() } else { 1.0 });
        let n = norms.len();
        let scaled = DMatrix::from_fn(n, n, |i, j| information[(i, j)] / (norms[i] * norms[j]));
        let smallest = scaled.symmetric_eigenvalues().min().max(0.0).sqrt();
        Choice { candidates, left, smallest }
    }
}

/// By how much the aims' variance sinks with these rows.
fn gain(rows: &DMatrix<f64>, covariance: &DMatrix<f64>, weighted: &DMatrix<f64>) -> f64 {
    let n = rows.nrows();
    let spread = DMatrix::identity(n, n) + rows * covariance * rows.transpose();
    let helped = rows * weighted * rows.transpose();
    spread.cholesky().map_or(0.0, |of| of.solve(&helped).trace())
}

/// The inverse of an information; scaled first, since its parameters have different units.
fn inverse(information: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let scale = information.diagonal().map(|square| if square > 0.0 { 1.0 / square.sqrt() } else { 1.0 });
    let n = scale.len();
    let scaled = DMatrix::from_fn(n, n, |i, j| information[(i, j)] * scale[i] * scale[j]);
    let inverse = scaled.cholesky()?.inverse();
    Some(DMatrix::from_fn(n, n, |i, j| inverse[(i, j)] * scale[i] * scale[j]))
}
