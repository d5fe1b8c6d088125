//! How much of an arm to calibrate: several fits to the same data, evaluated by what each foretells of postures that were left out.

use crate::chain::{Detail, Tolerances};
use crate::data::{Data, Scales, Stated};
use crate::fit::{Fit, NoFit};
use crate::least_squares::Settings;
use crate::loss::Loss;
use crate::parameter::Unit;
use crate::problem::{InstrumentId, Problem};

/// How residuals count in a calibration from data: beyond this many standard deviations by less than their squares.
const HUBER: f64 = 2.5;

/// A finer model must foretell better by this part to be taken.
const BETTER: f64 = 0.02;

/// Most postures that are left out one by one; more are left out in this many parts.
const ONE_BY_ONE: usize = 40;

/// Mean, root of the mean square, and maximum of errors.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Errors {
    /// How many there are.
    pub count: usize,
    /// Their mean [m or rad].
    pub mean: f64,
    /// The root of the mean of their squares.
    pub rms: f64,
    /// The largest.
    pub max: f64,
}

impl Errors {
    /// Those of some numbers, each >= 0.
    #[must_use]
    pub fn of(errors: impl IntoIterator<Item = f64>) -> Self {
        let (mut count, mut sum, mut squares, mut max) = (0, 0.0, 0.0, 0.0_f64);
        for error in errors {
            count += 1;
            sum += error;
            squares += error * error;
            max = max.max(error);
        }
        let n = f64::max(1.0, count as f64);
        Self { count, mean: sum / n, rms: (squares / n).sqrt(), max }
    }
}

/// Lengths of the differences by measurement \[m\], or of the angles \[rad\] where no lengths are measured.
#[must_use]
pub fn lengths(problem: &Problem, raw: &[(usize, Vec<f64>)]) -> Vec<(usize, f64)> {
    let norm = |i: &usize, raw: &[f64], unit: Unit| -> f64 {
        let device = problem.device_of(*i);
        raw.iter()
            .enumerate()
            .filter(|(j, _)| device.unit(*j) == unit)
            .map(|(_, r)| r * r)
            .sum::<f64>()
            .sqrt()
    };
    let has_lengths = raw.iter().any(|(i, _)| problem.device_of(*i).unit(0) == Unit::Metre);
    let unit = if has_lengths { Unit::Metre } else { Unit::Radian };
    let fits = raw.iter().filter(|(i, _)| problem.device_of(*i).unit(0) == unit);
    fits.map(|(i, raw)| (*i, norm(i, raw, unit))).collect()
}

/// One fit.
pub struct Trial {
    /// What was calibrated.
    pub detail: Detail,
    /// By what the tolerances were multiplied.
    pub factor: f64,
    /// The problem, and what came of it.
    pub stated: Stated,
    /// What came of it.
    pub fit: Fit,
    /// Errors at the postures that it was made from.
    pub within: Errors,
    /// Errors at postures that were left out.
    pub foretold: Errors,
}

impl Trial {
    /// Fits data.
    ///
    /// # Errors
    /// [`NoFit`].
    pub fn of(data: &Data, detail: Detail, factor: f64, scales: Scales) -> Result<Trial, NoFit> {
        let stated = data.problem(detail, &scaled(data.tolerances(), factor), scales)?;
        let fit = stated.problem.fit(&settings())?;
        let raw: Vec<(usize, Vec<f64>)> =
            fit.residuals().enumerate().map(|(i, (_, _, raw))| (i, raw.to_vec())).collect();
        let within = Errors::of(lengths(&stated.problem, &raw).into_iter().map(|(_, error)| error));
        let foretold = fit.cross_validated(folds(data.postures()))?;
        let foretold = Errors::of(lengths(&stated.problem, &foretold).into_iter().map(|(_, error)| error));
        Ok(Trial { detail, factor, stated, fit, within, foretold })
    }
}

/// Errors beyond which measurements are not those of the arm as it is described [m, or rad of angles alone].
const OTHER: f64 = 0.05;

impl Trial {
    /// Whether its measurements may be those of the arm as it is described: no more than 50 mm (50 mrad) rms are left. Units, signs or the order of columns are
    /// wrong otherwise.
    #[must_use]
    pub fn is_of_this_arm(&self) -> bool {
        self.within.rms < OTHER
    }
}

/// How residuals count, and when the iteration ends.
#[must_use]
pub fn settings() -> Settings {
    Settings { loss: Loss::Huber(HUBER), iterations: 200, tolerance: 1e-9 }
}

/// In how many parts postures are left out: one by one up to 40, then in ten parts.
#[must_use]
pub fn folds(postures: usize) -> usize {
    if postures <= ONE_BY_ONE { postures } else { 10 }
}

fn scaled(tolerances: Tolerances, by: f64) -> Tolerances {
    let Tolerances { length, angle, zero, encoder } = tolerances;
    // A zero is found from nothing else, and holds nothing back.
    Tolerances { length: length * by, angle: angle * by, zero: zero * by.max(1.0), encoder: encoder * by }
}

/// All fits: of the detail that is wanted, or of each, with tolerances of a third, once and three times; the first has frames alone.
///
/// # Errors
/// [`NoFit`] when frames alone have none; other trials without a fit are left out.
pub fn trials(data: &Data, wanted: Option<Detail>) -> Result<Vec<Trial>, NoFit> {
    let mut trials = vec![Trial::of(data, Detail::Frames, 1.0, Scales::Declared)?];
    let details = match wanted {
        Some(detail) => vec![detail],
        None => vec![Detail::Zeros, Detail::Geometry, Detail::Encoders],
    };
    for detail in details.into_iter().filter(|detail| *detail != Detail::Frames) {
        let factors: &[f64] = if detail == Detail::Zeros { &[1.0] } else { &[0.3, 1.0, 3.0] };
        let of = |factor: &f64| Trial::of(data, detail, *factor, Scales::Declared).ok();
        trials.extend(factors.iter().filter_map(of));
    }
    Ok(trials)
}

/// The trial to take: the one that foretells best, or a simpler one that does nearly as well. Errors of encoders, which no controller of a
/// cell corrects, only when they are wanted.
#[must_use]
pub fn chosen(trials: &[Trial], wanted: Option<Detail>) -> usize {
    let may = |trial: &Trial| match wanted {
        Some(detail) => trial.detail == detail,
        None => trial.detail != Detail::Encoders,
    };
    let mut best = 0;
    for (i, trial) in trials.iter().enumerate().filter(|(_, trial)| may(trial)) {
        let now = trials[best].foretold.mean;
        let enough = if trial.detail == trials[best].detail { 1.0 } else { 1.0 - BETTER };
        if !may(&trials[best]) || trial.foretold.mean < enough * now {
            best = i;
        }
    }
    best
}

/// A scale that was found beside everything else.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scale {
    /// By which part of a length the instrument reads too much.
    pub value: f64,
    /// Its standard deviation; `None` if it cannot be told from the other unknowns.
    pub sigma: Option<f64>,
}

impl Scale {
    /// Whether it is no accident: more than five standard deviations, and more than 0.1 %.
    #[must_use]
    pub fn is_wrong(&self) -> bool {
        self.sigma.is_some_and(|sigma| self.value.abs() > Self::shows(sigma))
    }

    /// The part from which an error shows, with this standard deviation.
    #[must_use]
    pub fn shows(sigma: f64) -> f64 {
        (5.0 * sigma).max(1e-3)
    }
}

/// The scales of all instruments that read lengths, found beside everything else.
///
/// # Errors
/// [`NoFit`].
pub fn scales(data: &Data, like: &Trial) -> Result<Vec<(usize, Scale)>, NoFit> {
    let tolerances = data.tolerances();
    let stated = data.problem(like.detail.min(Detail::Geometry), &tolerances, Scales::Free)?;
    let fit = stated.problem.fit_with_beliefs(&settings())?;
    let with_scale = (0..stated.instruments.len()).filter(|i| data.has_scale(*i));
    let one = |i: usize| {
        let id: InstrumentId = stated.instruments[i];
        let value = fit.constants(id).first().copied().unwrap_or(0.0);
        // Hardly narrower than what was believed before: the measurements say nothing of it.
        let sigma = fit.constant_sigma(id, 0).filter(|sigma| *sigma < 0.03);
        (i, Scale { value, sigma })
    };
    Ok(with_scale.map(one).collect())
}
