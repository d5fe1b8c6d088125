//! The summary of all variants: a table, and the bounds that were missed.

use core::fmt;

use mrroc::{CellError, CellFile};

use crate::lines::{Counts, LIMITS};
use crate::variant::{Bases, Sensors, Variant};
use crate::witness::Seen;

/// Bounds of what is measured.
const DEMANDED: f64 = 1e-9;
const SHARE: f64 = 0.2;
/// Runs of which the fastest counts.
const RUNS: usize = 3;

/// One line of the table.
pub struct Row {
    /// Which variant.
    pub variant: Variant,
    /// What was seen of it.
    pub seen: Seen,
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
    pub fn seen(&self, variant: Variant) -> Option<&Seen> {
        self.rows.iter().find(|row| row.variant == variant).map(|row| &row.seen)
    }

    /// Bounds that were missed, in words.
    #[must_use]
    pub fn missed(&self) -> Vec<String> {
        let mut missed = Vec::new();
        let Counts { transmit, trajectory, programs } = self.counts;
        let long = transmit > LIMITS.transmit || trajectory > LIMITS.trajectory || programs > LIMITS.programs;
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
        let peak = |sensors| {
            self.seen(Variant::Bar { bases: Bases::Off, sensors }).map_or(0.0, |seen| seen.internal)
        };
        let (without, with) = (peak(Sensors::Unused), peak(Sensors::Used));
        if with > SHARE * without {
            missed
                .push(format!("internal force with sensors: {with:.1} N, at most a fifth of {without:.1} N"));
        }
        missed
    }
}

impl Row {
    /// Whether the arms keep their relative pose, and give no way to forces.
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
            let Row { seen, speed, .. } = row;
            let (demanded, measured, strain) = (seen.demanded, seen.measured, seen.strain);
            write!(f, "{name:30}{:10.1e}{:10.1e}", demanded.distance, demanded.angle)?;
            write!(f, "{:9.3}{:9.3}", measured.distance * 1e3, measured.angle * 1e3)?;
            write!(f, "{:9.3}{:9.3}", strain.distance * 1e3, strain.angle * 1e3)?;
            writeln!(f, "{:10.2}{speed:8.0} x", seen.internal)?;
        }
        let time = self.rows.first().map_or(0.0, |row| row.time);
        writeln!(
            f,
            "largest values of {time:.1} s each; speed: times faster than real time, stepping alone"
        )?;
        writeln!(f, "{}", self.counts)
    }
}
