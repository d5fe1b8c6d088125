//! What was measured in one walk or in many, as a text.

use core::fmt::{self, Display, Formatter};

use crate::run::Outcome;
use crate::walk::{Gait, LEAST};

/// The largest slip of a step that is allowed \[m\].
pub const SLIP: f64 = 1e-3;

/// One walk.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// Its seed.
    pub seed: u64,
    /// Why it ended early.
    pub fault: Option<String>,
    /// Whether the machine fell.
    pub fallen: bool,
    /// How many steps legs made.
    pub steps: usize,
    /// Mean speed of the trunk from the first lift to the last landing [m/s].
    pub speed: f64,
    /// The least static margin \[m\].
    pub margin: f64,
    /// The largest slip of a step \[m\].
    pub slip: f64,
    /// The largest lean of the trunk \[rad\].
    pub lean: f64,
    /// The largest force on a foot \[N\].
    pub force: f64,
    /// How many times faster than real time it was.
    pub rate: f64,
}

impl Row {
    /// Of what came of a run.
    #[must_use]
    pub fn of(seed: u64, outcome: &Outcome) -> Self {
        let seen = &outcome.seen;
        let time = seen.film.last().map_or(0.0, |last| last.time);
        Self {
            seed,
            fault: outcome.report.as_ref().err().map(ToString::to_string),
            fallen: seen.fallen,
            steps: seen.steps.len(),
            speed: seen.speed(),
            margin: seen.margin,
            slip: seen.slip(),
            lean: seen.lean,
            force: seen.force,
            rate: time / outcome.wall.as_secs_f64().max(1e-9),
        }
    }

    /// Whether it walked to the end as it should.
    #[must_use]
    pub fn is_good(&self, gait: &Gait) -> bool {
        self.fault.is_none()
            && !self.fallen
            && self.steps == gait.footsteps
            && self.margin >= LEAST
            && self.slip <= SLIP
    }
}

/// All walks.
#[derive(Clone, Debug, PartialEq)]
pub struct Summary {
    /// The gait of all.
    pub gait: Gait,
    /// One for each.
    pub rows: Vec<Row>,
}

impl Summary {
    /// How many were not as they should be.
    #[must_use]
    pub fn bad(&self) -> usize {
        self.rows.iter().filter(|row| !row.is_good(&self.gait)).count()
    }
}

impl Display for Summary {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        for row in self.rows.iter().filter(|row| !row.is_good(&self.gait)) {
            let why = row.fault.as_deref().unwrap_or("a bound is missed");
            writeln!(f, "seed {}: {} steps, fallen: {}: {why}", row.seed, row.steps, row.fallen)?;
        }
        let count = self.rows.len();
        let least = |of: fn(&Row) -> f64| self.rows.iter().map(of).fold(f64::INFINITY, f64::min);
        let most = |of: fn(&Row) -> f64| self.rows.iter().map(of).fold(f64::NEG_INFINITY, f64::max);
        writeln!(f, "walked without a fault, within bounds  {} of {count}", count - self.bad())?;
        let steps: usize = self.rows.iter().map(|row| row.steps).sum();
        writeln!(
            f,
            "steps of legs                          {steps}, each leg stands {:.0} % of its time",
            100.0 * self.gait.duty()
        )?;
        writeln!(f, "speed of the trunk                     {:.4} m/s at least", least(|row| row.speed))?;
        writeln!(
            f,
            "static margin                          {:.1} mm at least, of {:.0} mm needed",
            1e3 * least(|row| row.margin),
            1e3 * LEAST
        )?;
        writeln!(
            f,
            "slip of a foot in a step               {:.2} mm at most, of {:.0} mm allowed",
            1e3 * most(|row| row.slip),
            1e3 * SLIP
        )?;
        writeln!(
            f,
            "lean of the trunk                      {:.2} deg at most",
            most(|row| row.lean).to_degrees()
        )?;
        writeln!(f, "force on a foot                        {:.0} N at most", most(|row| row.force))?;
        writeln!(
            f,
            "simulated                              {:.0} times as fast as real time at least",
            least(|row| row.rate)
        )
    }
}
