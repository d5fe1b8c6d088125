//! The cycle-time bound: how many parts arms can take at most.

use core::fmt;

use mrroc::prelude::*;

use super::run::Outcome;
use super::settings::Settings;
use crate::summary::quantile;

/// What arms need for a part where parts always wait for them: no more than one part in that time can be sorted by each.
#[derive(Clone, Debug, PartialEq)]
pub struct Bound {
    /// Nominal speed of the belt [m/s].
    pub speed: f64,
    /// How many arms there are.
    pub arms: usize,
    /// From one grasp of an arm to its next one, each \[s\].
    pub cycles: Vec<f64>,
}

impl Bound {
    /// So many parts come for each arm ..
    const PARTS: usize = 24;
    /// .. so many times as fast as it is believed to take them.
    const CROWD: f64 = 1.6;

    /// Of a cell like this, to which parts come faster than it can take them.
    ///
    /// # Errors
    /// What is wrong with the cell, or its fault.
    pub fn measured(settings: &Settings) -> Result<Self, CellError> {
        let arms = settings.arms.max(1);
        let every = Settings::CYCLE / (Self::CROWD * arms as f64);
        let crowded = Settings { parts: Self::PARTS * arms, every, ..*settings };
        let outcome = crowded.run()?;
        let of = Self::of(&outcome, settings.speed, arms);
        outcome.report.map(|_| of)
    }

    /// Of the grasps of a run. The first of each arm has waited for its part.
    #[must_use]
    pub fn of(outcome: &Outcome, speed: f64, arms: usize) -> Self {
        let mut cycles = Vec::new();
        for arm in 0..arms {
            let times: Vec<f64> =
                outcome.grips.iter().filter(|grip| grip.arm == arm).map(|grip| grip.time).collect();
            cycles.extend(times.windows(2).map(|pair| pair[1] - pair[0]));
        }
        Self { speed, arms, cycles }
    }

    /// The mean time that an arm needs for a part \[s\].
    #[must_use]
    pub fn cycle(&self) -> f64 {
        self.cycles.iter().sum::<f64>() / self.cycles.len().max(1) as f64
    }

    /// Parts that come so far apart in the mean keep all arms busy all the time \[s\].
    #[must_use]
    pub fn every(&self) -> f64 {
        self.cycle() / self.arms.max(1) as f64
    }
}

impl fmt::Display for Bound {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [least, most] = [0.0, 1.0].map(|share| quantile(&self.cycles, share));
        write!(
            f,
            "cycle-time bound at {:.2} m/s: an arm needs {:.2} s for a part ({least:.2} to {most:.2} s, {} picks without a pause), so {:.1} parts a minute",
            self.speed,
            self.cycle(),
            self.cycles.len(),
            60.0 / self.every()
        )
    }
}
