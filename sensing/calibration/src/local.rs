//! What the physical parameters cannot say: a smooth error of the joints, corrected where it was measured, if that helps.
//!
//! In: a fit. Out: a [`LocalCorrection`] of its arm, or none. With `r` the residuals in their standard deviations after the physical parameters, `J` and `S` their slopes by
//! those parameters and by the joints, `f` the functions of the correction and `s` how large its coefficients are believed to be, those of single joints and those of neighbours,
//!
//! ```text
//! |r + J x + S C f(q)|^2 + |C / s|^2  ->  least,   x eliminated
//! ```
//!
//! The parameters move meanwhile, since they took up what they could of it: without that, the correction would have to undo their part. It is solved for several `s`, the gain: a small one takes little of what was left. **When it is taken.** Each posture (or tenth of them) is left out of the physical parameters and of the correction,
//! and both foretell it. The correction must make the mean error there less by [`ENOUGH`], and by [`SURE`] standard errors of the mean of what postures gain. Noise
//! alone gains nothing there.

use mrroc::robot::JointKind;
use mrroc_robots::LocalCorrection;
use nalgebra::{DMatrix, DVector};

use crate::fit::{Fit, NoFit};
use crate::least_squares::{LeastSquares, minimise};
use crate::problem::{ArmId, Problem, Values};
use crate::trials::{Errors, lengths};

/// What the mean error must lose.
const ENOUGH: f64 = 0.05;

/// How many standard errors it must lose.
const SURE: f64 = 2.5;

/// How large coefficients of single joints, and of neighbours, may be believed to be [rad or m].
const SIZES: [[f64; 2]; 6] =
    [[5e-5, 5e-6], [2e-4, 1e-5], [7e-4, 2e-5], [3e-5, 3e-5], [1e-4, 1e-4], [3e-4, 3e-4]];

/// How far beside what was measured it fades out: this part of the range, and of turning joints at least this much \[rad\].
const FADES: f64 = 0.15;
const FADES_AT_LEAST: f64 = 0.3;

/// How wide a range is at least [rad or m]: of joints that were not moved.
const NARROWEST: f64 = 0.02;

/// Whether a local correction helps.
#[derive(Clone)]
pub struct LocalTrial {
    /// The correction, from all postures, and the fit to what it leaves; `None` if it does not help.
    pub taken: Option<(LocalCorrection, Fit)>,
    /// Errors at postures left out, without it.
    pub without: Errors,
    /// And with the best one.
    pub with: Errors,
    /// What postures gain on the mean, in its standard errors.
    pub sure: f64,
}

impl Fit {
    /// Looks whether a local correction of an arm helps. `kinds` are those of its joints, `folds` is as in [`Fit::cross_validated`].
    ///
    /// # Errors
    /// [`NoFit`] when a part alone has no fit.
    pub fn local(&self, arm: ArmId, kinds: &[JointKind], folds: usize) -> Result<LocalTrial, NoFit> {
        let problem = self.problem();
        let all: Vec<usize> = (0..problem.measurements()).collect();
        let folds = folds.clamp(2, problem.postures.len().max(2));
        let fold_of = |i: usize| problem.measurements[i].postures.first().map(|posture| posture.0 % folds);
        let (mut without, mut with) = (Vec::new(), vec![Vec::new(); SIZES.len()]);
        for fold in 0..folds {
            let (out, kept): (Vec<usize>, Vec<usize>) = all.iter().partition(|i| fold_of(**i) == Some(fold));
            if out.is_empty() || kept.is_empty() {
                continue;
            }
            let whitened = self.equations(kept.clone()).whitened(self.values());
            let values = minimise(&whitened, self.values().clone(), self.settings())?.at;
            let regression = self.regression(arm, kinds, &values, kept);
            without.extend(self.equations(out.clone()).raw(&values));
            for (size, with) in SIZES.iter().zip(&mut with) {
                let solved = regression.as_ref().and_then(|regression| regression.solved(*size));
                let (bent, values) = match solved {
                    Some((of, by)) => (bent(problem, arm, &of), values.moved(self.slots(), &by)),
                    None => (problem.clone(), values.clone()),
                };
                with.extend(self.equations_of(&bent, out.clone()).raw(&values));
            }
        }
        let told =
            |raw: &[(usize, Vec<f64>)]| Errors::of(lengths(problem, raw).into_iter().map(|(_, error)| error));
        let errors: Vec<Errors> = with.iter().map(|raw| told(raw)).collect();
        let best = (0..SIZES.len()).min_by(|a, b| errors[*a].mean.total_cmp(&errors[*b].mean)).unwrap_or(0);
        let (before, after) = (told(&without), errors[best]);
        let sure = sure(problem, &without, &with[best]);
        let helps = after.mean < (1.0 - ENOUGH) * before.mean && sure > SURE;
        let mut trial = LocalTrial { taken: None, without: before, with: after, sure };
        if helps {
            let regression = self.regression(arm, kinds, self.values(), all);
            if let Some((correction, _)) = regression.and_then(|regression| regression.solved(SIZES[best])) {
                let fit = bent(problem, arm, &correction).fit(self.settings())?;
                trial.taken = Some((correction, fit));
            }
        }
        Ok(trial)
    }

    /// What these measurements say of a correction, and of all else meanwhile.
    fn regression(
        &self,
        arm: ArmId,
        kinds: &[JointKind],
        values: &Values,
        used: Vec<usize>,
    ) -> Option<Regression> {
        let loss = self.settings().loss;
        let n = kinds.len();
        // Slopes by a unit of each joint.
        let mut problem = self.problem().clone();
        problem.arms.iter_mut().for_each(|arm| arm.scatter = Vec::new());
        let equations = self.equations_of(&problem, used);
        let (rows, columns) = (LeastSquares::residuals(&equations), equations.slots.len());
        let mut residuals = DVector::zeros(rows);
        let mut jacobian = DMatrix::zeros(rows, columns);
        equations.linearise(values, residuals.as_mut_slice(), &mut jacobian);
        let mut by_joint = problem.clone();
        by_joint.scatter(arm, &vec![1.0; n]);
        let slopes_of = self.equations_of(&by_joint, equations.used.clone());
        let posture_of =
            |i: usize| problem.measurements[i].postures.iter().find(|id| problem.postures[id.0].arm == arm);
        let measured = equations.used.iter().filter_map(|i| posture_of(*i));
        let empty = empty(kinds, &measured.map(|id| &problem.postures[id.0].q[..]).collect::<Vec<_>>());
        let count = empty.coefficients.len();
        let mut effect = DMatrix::zeros(rows, count * n);
        let mut functions = vec![0.0; count];
        let mut row = 0;
        for i in &equations.used {
            let k = problem.device_of(*i).residuals();
            if let Some(id) = posture_of(*i) {
                let mut slopes = DMatrix::zeros(k, n);
                slopes_of.shares(values, *i, id.0, &mut slopes);
                empty.functions(&problem.postures[id.0].q, &mut functions);
                for (f, value) in functions.iter().enumerate() {
                    let mut own = effect.view_mut((row, f * n), (k, n));
                    own += &slopes * *value;
                }
            }
            for r in row..row + k {
                let root = loss.weight(residuals[r]).sqrt();
                residuals[r] *= root;
                jacobian.row_mut(r).scale_mut(root);
                effect.row_mut(r).scale_mut(root);
            }
            row += k;
        }
        let norms: Vec<f64> = jacobian.column_iter().map(|column| column.norm()).collect();
        for (mut column, norm) in jacobian.column_iter_mut().zip(&norms) {
            column /= norm.max(f64::MIN_POSITIVE);
        }
        let own = jacobian.tr_mul(&jacobian).cholesky()?;
        let (mixed, gradient) = (jacobian.tr_mul(&effect), jacobian.tr_mul(&residuals));
        let (by_effect, by_residuals) = (own.solve(&mixed), own.solve(&gradient));
        let normal = effect.tr_mul(&effect) - mixed.tr_mul(&by_effect);
        let gradient = effect.tr_mul(&residuals) - mixed.tr_mul(&by_residuals);
        Some(Regression { empty, normal, gradient, by_effect, by_residuals, norms })
    }
}

/// No correction, where these postures were measured.
fn empty(kinds: &[JointKind], postures: &[&[f64]]) -> LocalCorrection {
    let n = kinds.len();
    let range = (0..n).map(|j| {
        let positions = || postures.iter().map(|q| q[j]);
        let low = positions().fold(f64::INFINITY, f64::min);
        let high = positions().fold(f64::NEG_INFINITY, f64::max);
        let pad = 0.5 * (NARROWEST - (high - low)).max(0.0);
        let least = if kinds[j] == JointKind::Revolute { FADES_AT_LEAST } else { NARROWEST };
        [low - pad, high + pad, (FADES * (high - low)).max(least)]
    });
    let coefficients = vec![vec![0.0; n]; LocalCorrection::count(n)];
    LocalCorrection { range: range.collect(), kinds: kinds.to_owned(), coefficients }
}

/// The normal equations of the coefficients, with all else eliminated, and without what is believed of them.
struct Regression {
    empty: LocalCorrection,
    normal: DMatrix<f64>,
    gradient: DVector<f64>,
    /// How all else moves with the coefficients, and by itself, in units of `norms`.
    by_effect: DMatrix<f64>,
    by_residuals: DVector<f64>,
    norms: Vec<f64>,
}

impl Regression {
    /// The correction, and by how much all else moves; `None` if there is none that a file may have.
    fn solved(&self, [single, neighbours]: [f64; 2]) -> Option<(LocalCorrection, Vec<f64>)> {
        let mut found = self.empty.clone();
        let n = found.kinds.len();
        let mut normal = self.normal.clone();
        for i in 0..normal.nrows() {
            let size = if i < 2 * n * n { single } else { neighbours };
            normal[(i, i)] += size.powi(-2);
        }
        let solved = -normal.cholesky()?.solve(&self.gradient);
        for (k, row) in found.coefficients.iter_mut().enumerate() {
            row.iter_mut().enumerate().for_each(|(j, one)| *one = solved[k * n + j]);
        }
        let moved = -&self.by_residuals - &self.by_effect * &solved;
        let moved =
            moved.iter().zip(&self.norms).map(|(by, norm)| by / norm.max(f64::MIN_POSITIVE)).collect();
        found.check().is_ok().then_some((found, moved))
    }
}

/// The same problem, with an arm's joints where a correction says they are.
#[must_use]
pub fn bent(problem: &Problem, arm: ArmId, by: &LocalCorrection) -> Problem {
    let mut bent = problem.clone();
    for posture in bent.postures.iter_mut().filter(|posture| posture.arm == arm) {
        let off = by.at(&posture.q);
        posture.q.iter_mut().zip(off).for_each(|(q, off)| *q += off);
    }
    bent
}

/// What postures gain on the mean, in its standard errors.
fn sure(problem: &Problem, without: &[(usize, Vec<f64>)], with: &[(usize, Vec<f64>)]) -> f64 {
    let mut gains: Vec<(f64, f64)> = vec![(0.0, 0.0); problem.postures.len()];
    // Both have the same measurements, in the same order.
    for ((i, before), (_, after)) in lengths(problem, without).into_iter().zip(lengths(problem, with)) {
        if let Some(posture) = problem.measurements[i].postures.first() {
            gains[posture.0].0 += before - after;
            gains[posture.0].1 += 1.0;
        }
    }
    let gains: Vec<f64> = gains.iter().filter(|(_, n)| *n > 0.0).map(|(sum, n)| sum / n).collect();
    let n = gains.len() as f64;
    let mean = gains.iter().sum::<f64>() / n;
    let square = gains.iter().map(|gain| (gain - mean).powi(2)).sum::<f64>() / (n - 1.0).max(1.0);
    mean / (square / n).sqrt().max(f64::MIN_POSITIVE)
}
