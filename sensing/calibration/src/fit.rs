//! Solving a problem: what is found, how sure it is, and what cannot be seen.

use core::fmt;

use mrroc::pose::Pose;
use nalgebra::{DMatrix, Matrix6, Vector6};

use crate::equations::Equations;
use crate::information::{Information, Unseen, covariance};
use crate::least_squares::{NoMinimum, Settings, minimise};
use crate::parameter::{Parameter, Unit};
use crate::problem::{ArmId, FrameId, InstrumentId, Noise, Posture, Problem, Slot, TargetId, Values};

/// Why there is no fit.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum NoFit {
    /// Nothing was measured.
    #[error("nothing was measured: a problem needs measurements")]
    Empty,
    /// The iteration found nothing.
    #[error(transparent)]
    NoMinimum(#[from] NoMinimum),
    /// All starts failed.
    #[error("no start leads to a fit of `{instrument}`: say about where it stands")]
    NoStart {
        /// The instrument's name.
        instrument: String,
    },
}

/// A parameter that was found.
#[derive(Clone, Debug, PartialEq)]
pub struct FoundParameter {
    /// What it is.
    pub parameter: Parameter,
    /// How far it is from what was believed [m, rad or 1].
    pub value: f64,
    /// Its standard deviation.
    pub sigma: f64,
}

/// Parameters that can move together without any instrument noticing.
#[derive(Clone, Debug, PartialEq)]
pub struct Indistinct {
    /// The one that was left as it was believed.
    pub fixed: Parameter,
    /// The others, with how far each moves for a unit of the fixed one.
    pub with: Vec<(Parameter, f64)>,
}

impl fmt::Display for Indistinct {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let fixed = &self.fixed.name;
        let near = |moved: f64, one: f64| (moved - one).abs() < 2e-3;
        match &self.with[..] {
            [] => write!(f, "{fixed}: nothing depends on it"),
            [(other, moved)] if near(*moved, -1.0) => write!(f, "{fixed} and {}: only their sum", other.name),
            [(other, moved)] if near(*moved, 1.0) => {
                write!(f, "{fixed} and {}: only their difference", other.name)
            }
            [(other, _)] => write!(f, "{fixed} and {}: only a combination", other.name),
            several => {
                let names: Vec<&str> = several.iter().map(|(other, _)| other.name.as_str()).take(4).collect();
                let others = several.len() - names.len();
                let and = if others > 0 { format!(" and {others} others") } else { String::new() };
                write!(f, "{fixed}, {}{and}: only combinations", names.join(", "))
            }
        }
    }
}

/// What came of a problem.
#[derive(Clone)]
pub struct Fit {
    problem: Problem,
    values: Values,
    slots: Vec<Slot>,
    covariance: DMatrix<f64>,
    information: Information,
    indistinct: Vec<Indistinct>,
    raw: Vec<(usize, Vec<f64>)>,
    unit: Vec<f64>,
    sigma: Vec<Vec<f64>>,
    iterations: usize,
    settings: Settings,
}

/// What counts as seen.
#[derive(Clone, Copy)]
enum Seen {
    Measured,
    Believed,
}

/// How often the noise is found anew: each time it changes less.
const NOISE_ROUNDS: usize = 4;

impl Problem {
    /// Finds everything that is to be found.
    ///
    /// What cannot be seen is left as it was believed, and told by [`Fit::unseen`].
    ///
    /// # Errors
    /// [`NoFit`].
    pub fn fit(&self, settings: &Settings) -> Result<Fit, NoFit> {
        self.fit_seen_by(Seen::Measured, settings)
    }

    /// The same, where what is believed counts as seen: tolerances tell apart what measurements do not.
    ///
    /// # Errors
    /// [`NoFit`].
    pub fn fit_with_beliefs(&self, settings: &Settings) -> Result<Fit, NoFit> {
        self.fit_seen_by(Seen::Believed, settings)
    }

    fn fit_seen_by(&self, seen: Seen, settings: &Settings) -> Result<Fit, NoFit> {
        if self.measurements.is_empty() {
            return Err(NoFit::Empty);
        }
        let used: Vec<usize> = (0..self.measurements.len()).collect();
        let mut sigma: Vec<Vec<f64>> =
            self.instruments.iter().map(|one| one.noise.sigma().to_vec()).collect();
        let all = self.slots();
        let mut values = self.start();
        let mut iterations = 0;
        let rounds = if self.knows_noise() { 1 } else { NOISE_ROUNDS };
        let mut last = None;
        for _ in 0..rounds {
            let equations = Equations::new(self, all.clone(), used.clone(), sigma.clone()).whitened(&values);
            let minimum = minimise(&equations, values, settings)?;
            iterations += minimum.iterations;
            values = minimum.at;
            let freedom = degrees_of_freedom(&equations, &minimum.jacobian);
            self.find_noise(&equations, &values, freedom, settings, &mut sigma);
            let rows = match seen {
                Seen::Measured => equations.measured(),
                Seen::Believed => minimum.jacobian.nrows(),
            };
            last = Some((minimum.jacobian, rows));
        }
        let Some((jacobian, measured)) = last else { return Err(NoFit::Empty) };
        let importance: Vec<u8> = all.iter().map(|slot| self.parameter(*slot).importance).collect();
        let information = Information::of(&jacobian.rows(0, measured).into_owned(), &importance);
        let indistinct = information.unseen.iter().map(|unseen| self.told(&all, unseen)).collect();
        let slots: Vec<Slot> = all
            .iter()
            .enumerate()
            .filter(|(i, _)| information.unseen.iter().all(|unseen| unseen.fixed != *i))
            .map(|(_, slot)| *slot)
            .collect();
        // Along what no instrument notices, back to where what is fixed was believed to be; what round-off leaves is put there.
        let start = self.start();
        let mut back = vec![0.0; all.len()];
        for unseen in
            information.unseen.iter().filter(|unseen| !matches!(all[unseen.fixed], Slot::Frame { .. }))
        {
            let off = values.get(all[unseen.fixed], &start);
            back[unseen.fixed] -= off;
            unseen.with.iter().for_each(|(i, moved)| back[*i] -= moved * off);
        }
        values = values.moved(&all, &back);
        for unseen in &information.unseen {
            values.reset(all[unseen.fixed]);
        }
        let equations = Equations::new(self, slots.clone(), used, sigma.clone()).whitened(&values);
        let minimum = minimise(&equations, values, settings)?;
        Ok(Fit {
            raw: equations.raw(&minimum.at),
            unit: minimum.residuals.rows(0, equations.measured()).iter().copied().collect(),
            covariance: covariance(&minimum.jacobian),
            problem: self.clone(),
            values: minimum.at,
            slots,
            information,
            indistinct,
            sigma,
            iterations: iterations + minimum.iterations,
            settings: *settings,
        })
    }

    fn knows_noise(&self) -> bool {
        self.instruments.iter().all(|one| matches!(one.noise, Noise::Known(_)))
    }

    fn told(&self, slots: &[Slot], unseen: &Unseen) -> Indistinct {
        let with = unseen
            .with
            .iter()
            .take(unseen.named)
            .map(|(i, moved)| (self.parameter(slots[*i]), *moved))
            .collect();
        Indistinct { fixed: self.parameter(slots[unseen.fixed]), with }
    }

    /// The noise of the instruments that do not know theirs, one number for lengths, one for angles and one for pixels each.
    fn find_noise(
        &self,
        equations: &Equations<'_>,
        values: &Values,
        freedom: f64,
        settings: &Settings,
        sigma: &mut [Vec<f64>],
    ) {
        let mut raw = equations.raw(values);
        // Of what measurements of a posture share, only the instrument's part is its noise.
        let plain = equations.plain(values);
        for block in equations.blocks(values) {
            let noise = block.noise(plain.as_slice());
            let mut rows = noise.iter();
            for (i, _, count) in &block.parts {
                let own = &sigma[self.measurements[*i].instrument.0];
                let Ok(at) = raw.binary_search_by_key(i, |(i, _)| *i) else { continue };
                for (raw, (sigma, (_, square))) in
                    raw[at].1.iter_mut().zip(own.iter().zip(rows.by_ref().take(*count)))
                {
                    *raw = sigma * square.sqrt();
                }
            }
        }
        for (i, instrument) in self.instruments.iter().enumerate() {
            if matches!(instrument.noise, Noise::Known(_)) {
                continue;
            }
            for unit in [Unit::Metre, Unit::Radian, Unit::Pixel] {
                let of = (0..instrument.device.residuals()).filter(|j| instrument.device.unit(*j) == unit);
                let of: Vec<usize> = of.collect();
                let own = raw.iter().filter(|(m, _)| self.measurements[*m].instrument.0 == i);
                let all: Vec<f64> =
                    own.flat_map(|(_, raw)| of.iter().filter_map(|j| raw.get(*j).copied())).collect();
                let weight = |r: &f64| settings.loss.weight(r / of.first().map_or(1.0, |j| sigma[i][*j]));
                let weights: f64 = all.iter().map(weight).sum();
                let square: f64 = all.iter().map(|r| weight(r) * r * r).sum();
                // Noise below round-off is none.
                let found = (square / (weights * freedom)).sqrt();
                if found.is_finite() {
                    of.iter().for_each(|j| sigma[i][*j] = found.max(1e-12));
                }
            }
        }
    }
}

/// The part of the measurements that is left for the residuals: `1 - tr(J_m (J^T J)^-1 J_m^T) / m`, at least 0.05.
fn degrees_of_freedom(equations: &Equations<'_>, jacobian: &DMatrix<f64>) -> f64 {
    let m = equations.measured();
    let measured = jacobian.rows(0, m);
    let used = (measured.tr_mul(&measured) * covariance(jacobian)).trace();
    (1.0 - used / m as f64).max(0.05)
}

impl Fit {
    /// All that was found, in the order arms' bases, instruments, targets, then parameters of arms and constants.
    pub fn found(&self) -> impl Iterator<Item = FoundParameter> {
        let start = self.problem.start();
        self.slots.iter().enumerate().map(move |(i, slot)| FoundParameter {
            parameter: self.problem.parameter(*slot),
            value: self.values.get(*slot, &start),
            sigma: self.covariance[(i, i)].max(0.0).sqrt(),
        })
    }

    /// The covariance of what was found, in its order.
    #[must_use]
    pub fn covariance(&self) -> &DMatrix<f64> {
        &self.covariance
    }

    /// What cannot be seen, and was left as it was believed.
    #[must_use]
    pub fn unseen(&self) -> &[Indistinct] {
        &self.indistinct
    }

    /// The singular values, from the largest, of the measurements' Jacobian with columns of norm 1, and its rank.
    #[must_use]
    pub fn information(&self) -> &Information {
        &self.information
    }

    /// The values of an arm's parameters, in its order.
    #[must_use]
    pub fn arm(&self, arm: ArmId) -> &[f64] {
        self.problem.arms[arm.0].parts(&self.values.arms[arm.0]).0
    }

    /// The compliances of an arm [rad/(N m) or m/N], in their order.
    #[must_use]
    pub fn compliances(&self, arm: ArmId) -> &[f64] {
        self.problem.arms[arm.0].parts(&self.values.arms[arm.0]).1
    }

    /// Where in the order of [`Fit::found`] each parameter of an arm is; `None` of one that was not to be found or could not be seen.
    #[must_use]
    pub fn columns_of(&self, arm: ArmId) -> Vec<Option<usize>> {
        let column = |i| self.slots.iter().position(|slot| *slot == Slot::Arm { arm: arm.0, i });
        (0..self.values.arms[arm.0].len()).map(column).collect()
    }

    /// The values of an instrument's constants.
    #[must_use]
    pub fn constants(&self, instrument: InstrumentId) -> &[f64] {
        &self.values.instruments[instrument.0]
    }

    /// The standard deviation of a constant of an instrument; `None` if it cannot be seen.
    #[must_use]
    pub fn constant_sigma(&self, instrument: InstrumentId, constant: usize) -> Option<f64> {
        let wanted = Slot::Constant { instrument: instrument.0, i: constant };
        let column = self.slots.iter().position(|slot| *slot == wanted)?;
        Some(self.covariance[(column, column)].max(0.0).sqrt())
    }

    /// A frame: in the world, or on the flange of what carries it.
    #[must_use]
    pub fn frame(&self, frame: FrameId) -> Pose {
        self.values.frames[frame.0]
    }

    /// The standard deviations of the residuals of an instrument [m or rad].
    #[must_use]
    pub fn noise(&self, instrument: InstrumentId) -> &[f64] {
        &self.sigma[instrument.0]
    }

    /// How often the problem was linearised.
    #[must_use]
    pub fn iterations(&self) -> usize {
        self.iterations
    }

    /// By measurement what its instrument read more than foretold [m or rad], in the order in which they were told.
    pub fn residuals(&self) -> impl ExactSizeIterator<Item = (InstrumentId, TargetId, &[f64])> {
        self.raw.iter().map(|(i, raw)| {
            let measurement = &self.problem.measurements[*i];
            (measurement.instrument, measurement.target, &raw[..])
        })
    }

    /// What is left of all measurements, and of known distances, in units of their standard deviations; what the measurements of a posture share is
    /// taken out. If the problem is as it was told, they are normally distributed, with a standard deviation of 1.
    #[must_use]
    pub fn unit_residuals(&self) -> &[f64] {
        &self.unit
    }

    /// Where a target of an arm is in the world at `q`, with the covariance of its displacement along the world's axes: x, y, z \[m\], and turns about its
    /// origin \[rad\]; what its joints scatter by is in it.
    #[must_use]
    pub fn place(&self, arm: ArmId, q: &[f64], target: FrameId) -> (Pose, Matrix6<f64>) {
        self.place_loaded(arm, q, &[], target)
    }

    /// The same with the torques that bend the arm's compliances [N m or N].
    #[must_use]
    pub fn place_loaded(
        &self,
        arm: ArmId,
        q: &[f64],
        torques: &[f64],
        target: FrameId,
    ) -> (Pose, Matrix6<f64>) {
        let equations = self.equations(Vec::new());
        let posture = Posture { arm, q: q.to_owned(), torques: torques.to_owned() };
        let flange = equations.flange(&self.values, &posture, true);
        let there = equations.mounted(&self.values, Some(&flange), target, true);
        let mut covariance = self.spread(&there.twists);
        for twist in equations.scattered(&self.values, &posture, &there.pose) {
            covariance += twist * twist.transpose();
        }
        (there.pose, covariance)
    }

    /// Where the base of one arm is in that of another, with the covariance of its displacement along the axes of that other base.
    #[must_use]
    pub fn between(&self, from: FrameId, to: FrameId) -> (Pose, Matrix6<f64>) {
        let equations = self.equations(Vec::new());
        let (pose, twists) = equations.apart(&self.values, from, to);
        (pose, self.spread(&twists))
    }

    pub(crate) fn equations(&self, used: Vec<usize>) -> Equations<'_> {
        self.equations_of(&self.problem, used)
    }

    /// The same of another problem with the same blocks.
    pub(crate) fn equations_of<'p>(&self, problem: &'p Problem, used: Vec<usize>) -> Equations<'p> {
        Equations::new(problem, self.slots.clone(), used, self.sigma.clone())
    }

    pub(crate) fn problem(&self) -> &Problem {
        &self.problem
    }

    pub(crate) fn slots(&self) -> &[Slot] {
        &self.slots
    }

    pub(crate) fn values(&self) -> &Values {
        &self.values
    }

    pub(crate) fn settings(&self) -> &Settings {
        &self.settings
    }

    fn spread(&self, twists: &[(usize, Vector6<f64>)]) -> Matrix6<f64> {
        let mut by_column = DMatrix::zeros(6, self.slots.len());
        for (column, one) in twists {
            let mut sum = by_column.column_mut(*column);
            sum += one;
        }
        let spread = &by_column * &self.covariance * by_column.transpose();
        Matrix6::from_fn(|i, j| spread[(i, j)])
    }

    /// Leaves out a part of the postures, finds everything without them, and foretells what was measured there; until each posture was left
    /// out once. Returns by measurement the difference [m or rad].
    ///
    /// `folds` is how many parts there are: at most the number of postures, at least 2. The postures are dealt to them in turn.
    ///
    /// # Errors
    /// [`NoFit`] when a part alone has no fit.
    pub fn cross_validated(&self, folds: usize) -> Result<Vec<(usize, Vec<f64>)>, NoFit> {
        let folds = folds.clamp(2, self.problem.postures.len().max(2));
        let fold_of =
            |i: usize| self.problem.measurements[i].postures.first().map(|posture| posture.0 % folds);
        let mut foretold = Vec::new();
        for fold in 0..folds {
            let (out, kept): (Vec<usize>, Vec<usize>) =
                (0..self.problem.measurements.len()).partition(|i| fold_of(*i) == Some(fold));
            if out.is_empty() || kept.is_empty() {
                continue;
            }
            let kept = self.equations(kept).whitened(&self.values);
            let minimum = minimise(&kept, self.values.clone(), &self.settings)?;
            foretold.extend(self.equations(out).raw(&minimum.at));
        }
        foretold.sort_by_key(|(i, _)| *i);
        Ok(foretold)
    }

    /// What the arms found here foretell of other measurements: by measurement of `other`, a problem with the same blocks, the difference
    /// [m or rad].
    #[must_use]
    pub fn foretold(&self, other: &Problem) -> Vec<(usize, Vec<f64>)> {
        let used = (0..other.measurements.len()).collect();
        Equations::new(other, self.slots.clone(), used, self.sigma.clone()).raw(&self.values)
    }
}
