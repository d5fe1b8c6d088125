//! The summary of all variants: a table, and the bounds that were missed.

use core::fmt;

use mrroc::prelude::*;

use crate::lines::{Counts, LIMITS};
use crate::monitor::RunMeasurements;
use crate::variant::{Bases, Sensors, Variant};

/// Bounds of what is measured.
const DEMANDED: f64 = 1e-9;
const SHARE: f64 = 0.2;
/// So many runs are made, and the fastest counts.
const RUNS: usize = 3;

/// One line of the table.
pub struct Row {
    /// Which variant.
    pub variant: Variant,
    /// What was seen of it.
    pub seen: RunMeasurements,
    /// Simulated time \[s\].
    pub time: f64,
    /// How many times faster than real time it stepped.
    pub speed: f64,
}

/// All variants.
pub struct Summary {
    rows: Vec<Row>,
    counts: Counts,
}

/// The variants in the order of the table.
const VARIANTS: [(Variant, &str); 4] = [
    (Variant::Empty, "arms alone"),
    (Variant::Bar { bases: Bases::Calibrated, sensors: Sensors::Unused }, "a bar"),
    (Variant::Bar { bases: Bases::Off, sensors: Sensors::Unused }, "a base off by 1 mm, 0.1 deg"),
    (Variant::Bar { bases: Bases::Off, sensors: Sensors::Used }, ".. with force sensors"),
];

impl Summary {
    /// Puts the cell together once for each variant, and lets nothing move.
    ///
    /// # Errors
    /// What is wrong with the file.
    pub fn check(file: &CellFile) -> Result<(), CellError> {
        VARIANTS.iter().try_for_each(|(variant, _)| variant.ready(file).map(drop))
    }

    /// Runs all variants of a cell, unwatched for their speed, then watched.
    ///
    /// # Errors
    /// The first cause when a run ends with a fault.
    pub fn measure(file: &CellFile) -> Result<Summary, CellError> {
        let rows = VARIANTS.iter().map(|&(variant, _)| {
            // The best of some: what else the computer does is not to be measured.
            let mut speed = 0.0_f64;
            for _ in 0..RUNS {
                speed = speed.max(variant.run(file)?.speed());
            }
            let seen = variant.watched(file, |cell, _| cell)?;
            let time = seen.samples.last().map_or(0.0, |sample| sample.time);
            Ok(Row { variant, seen, time, speed })
        });
        Ok(Summary { rows: rows.collect::<Result<_, CellError>>()?, counts: Counts::of_this_task() })
    }

    /// What was seen of a variant.
    #[must_use]
    pub fn seen(&self, variant: Variant) -> Option<&RunMeasurements> {
        self.rows.iter().find(|row| row.variant == variant).map(|row| &row.seen)
    }

    /// Bounds that were missed, in words.
    #[must_use]
    pub fn missed(&self) -> Vec<String> {
        let mut missed = Vec::new();
        let Counts { transmit, trajectory, path, programs } = self.counts;
        let long = transmit > LIMITS.transmit
            || trajectory > LIMITS.trajectory
            || path > LIMITS.path
            || programs > LIMITS.programs;
        if long {
            missed.push(self.counts.to_string());
        }
        for row in self.rows.iter().filter(|row| row.is_rigid()) {
            let worst = row.seen.demanded.distance.max(row.seen.demanded.angle);
            if worst > DEMANDED {
                missed.push(format!(
                    "relative pose error of the demands: {worst:.1e}, at most {DEMANDED:.0e} m and rad"
                ));
            }
        }
        let held = self.rows.iter().all(|row| row.seen.is_held());
        if !held {
            missed.push("the hands have not closed on the bar".to_owned());
        }
        let peak = |sensors| {
            self.seen(Variant::Bar { bases: Bases::Off, sensors }).map_or(0.0, |seen| seen.internal)
        };
        let without = peak(Sensors::Unused);
        let with = peak(Sensors::Used);
        // Asked so that no number at all is a miss, too.
        let eased = without > 0.0 && with <= SHARE * without;
        if !eased {
            missed.push(format!(
                "internal force with sensors: {with:.1} N, at most a fifth of {without:.1} N, which must be above 0"
            ));
        }
        missed
    }
}

impl Row {
    /// Whether the arms keep their relative pose, and do not yield to forces.
    fn is_rigid(&self) -> bool {
        !matches!(self.variant, Variant::Bar { sensors: Sensors::Used, .. })
    }
}

impl fmt::Display for Summary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "{:30}{:^20}{:^18}{:^18}{:>10}",
            "", "demands apart", "encoders apart", "body strained", "pressed"
        )?;
        writeln!(
            f,
            "{:30}{:>10}{:>10}{:>9}{:>9}{:>9}{:>9}{:>10}{:>10}",
            "", "m", "rad", "mm", "mrad", "mm", "mrad", "N", "speed"
        )?;
        for (row, (_, name)) in self.rows.iter().zip(VARIANTS) {
            let Row { seen: RunMeasurements { demanded, measured, strain, internal, .. }, speed, .. } = row;
            write!(f, "{name:30}{:10.1e}{:10.1e}", demanded.distance, demanded.angle)?;
            write!(f, "{:9.3}{:9.3}", measured.distance * 1e3, measured.angle * 1e3)?;
            write!(f, "{:9.3}{:9.3}", strain.distance * 1e3, strain.angle * 1e3)?;
            writeln!(f, "{:10.2}{speed:8.0} x", internal)?;
        }
        let time = self.rows.first().map_or(0.0, |row| row.time);
        writeln!(
            f,
            "largest values of {time:.1} s each; speed: times faster than real time, stepping alone"
        )?;
        writeln!(f, "{}", self.counts)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A summary in which without and with sensors the force was so large \[N\].
    fn with_forces(without: f64, with: f64) -> Summary {
        let rows = VARIANTS.iter().zip([0.0, 1.0, without, with]).map(|(&(variant, _), internal)| {
            let mut seen = RunMeasurements::default();
            (seen.internal, seen.carried) = (internal, 1);
            Row { variant, seen, time: 1.0, speed: 1.0 }
        });
        Summary { rows: rows.collect(), counts: LIMITS }
    }

    #[test]
    fn a_force_that_is_not_eased_or_never_was_is_missed_and_so_is_a_grasp_that_was_none() {
        assert_eq!(with_forces(10.0, 2.0).missed(), Vec::<String>::new());
        for (without, with) in [(10.0, 2.1), (0.0, 0.0), (f64::NAN, 1.0), (10.0, f64::NAN)] {
            assert_eq!(with_forces(without, with).missed().len(), 1, "{without} N, {with} N");
        }
        for row in 0..VARIANTS.len() {
            let mut summary = with_forces(10.0, 2.0);
            let seen = &mut summary.rows[row].seen;
            seen.loose = 1;
            assert_eq!(summary.missed().len(), 1, "row {row}");
            let seen = &mut summary.rows[row].seen;
            (seen.carried, seen.loose) = (0, 0);
            assert_eq!(summary.missed().len(), 1, "row {row}");
        }
    }
}
