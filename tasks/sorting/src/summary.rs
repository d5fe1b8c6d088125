//! Many runs: how parts fare at each speed of the belt.

use core::fmt;
use std::thread;

use mrroc::prelude::*;

use crate::monitor::Fate;
use crate::run::{Outcome, Sensing, Settings};

/// The nominal speeds of a sweep [m/s], from 0.02 to 0.15.
pub const SPEEDS: usize = 14;

/// What came of the runs at one nominal speed, or of all.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Row {
    /// Nominal [m/s]; of all: 0.
    pub speed: f64,
    /// Parts that came.
    pub parts: usize,
    /// In the right tray.
    pub sorted: usize,
    /// In the wrong tray.
    pub wrong: usize,
    /// Over the end of the belt.
    pub missed: usize,
    /// Runs that ended with a fault.
    pub faults: usize,
    /// Fingers that came down on a part.
    pub crashes: u32,
    /// Picks in which the hand closed on nothing, and was opened again.
    pub failed: u32,
    /// Distance of the part's middle from that of the fingers along the belt, of each grasp \[m\].
    pub off: Vec<f64>,
    /// Relative speed along the belt at the first touch, of each grasp [m/s].
    pub slip: Vec<f64>,
    /// Simulated time, and how long it took \[s\].
    pub time: f64,
    /// See [`time`](Self::time).
    pub wall: f64,
}

impl Row {
    /// Counts a run.
    pub fn add(&mut self, outcome: &Outcome) {
        self.parts += outcome.fates.len();
        self.sorted += outcome.count(Fate::Sorted);
        self.wrong += outcome.count(Fate::Wrong);
        self.missed += outcome.count(Fate::Missed);
        self.crashes += outcome.crashes;
        self.failed += outcome.failed;
        self.off.extend(outcome.grips.iter().map(|grip| grip.along.abs()));
        self.slip.extend(outcome.grips.iter().map(|grip| grip.slip.abs()));
        match &outcome.report {
            Ok(report) => {
                self.time += report.time.as_secs_f64();
                self.wall += outcome.wall.as_secs_f64();
            }
            Err(_) => self.faults += 1,
        }
    }

    fn join(&mut self, other: &Row) {
        self.parts += other.parts;
        self.sorted += other.sorted;
        self.wrong += other.wrong;
        self.missed += other.missed;
        self.faults += other.faults;
        self.crashes += other.crashes;
        self.failed += other.failed;
        self.off.extend(&other.off);
        self.slip.extend(&other.slip);
        self.time += other.time;
        self.wall += other.wall;
    }

    /// Whether no part is in a wrong tray, no finger came down on one, no run ended with a fault, and any part was sorted.
    #[must_use]
    pub const fn is_well(&self) -> bool {
        self.wrong == 0 && self.crashes == 0 && self.faults == 0 && self.sorted > 0
    }

    /// The share of parts in the right tray.
    #[must_use]
    pub fn share(&self) -> f64 {
        self.sorted as f64 / self.parts.max(1) as f64
    }

    /// How many times faster than real time the runs were, each on one processor.
    #[must_use]
    pub fn pace(&self) -> f64 {
        if self.wall > 0.0 { self.time / self.wall } else { 0.0 }
    }
}

/// The value that a share of the values, 0 to 1, does not exceed; 0 of none.
#[must_use]
pub fn quantile(values: &[f64], share: f64) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_unstable_by(f64::total_cmp);
    let place = (share * sorted.len() as f64).ceil() as usize;
    sorted.get(place.max(1) - 1).copied().unwrap_or(0.0)
}

/// A row for each speed.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Summary(pub Vec<Row>);

impl Summary {
    /// One part for each of so many seeds, on all processors; the speeds take turns.
    ///
    /// # Errors
    /// What is wrong with the cell; a fault of a run is counted.
    ///
    /// # Panics
    /// If a run does.
    pub fn sweep(seeds: u64, sensing: Sensing) -> Result<Self, CellError> {
        let workers = thread::available_parallelism().map_or(1, |count| count.get() as u64);
        let work = |worker: u64| -> Result<Vec<Row>, String> {
            let mut rows = empty();
            for seed in (worker..seeds).step_by(workers as usize) {
                let row = &mut rows[seed as usize % SPEEDS];
                let settings = Settings { sensing, ..Settings::one(row.speed, seed) };
                row.add(&settings.run().map_err(|error| error.to_string())?);
            }
            Ok(rows)
        };
        let mut rows = empty();
        let done = thread::scope(|scope| {
            let started: Vec<_> = (0..workers).map(|worker| scope.spawn(move || work(worker))).collect();
            started
                .into_iter()
                .map(|worker| worker.join().expect("no run panics"))
                .collect::<Result<Vec<_>, _>>()
        });
        for done in done.map_err(|text| Fault::thrown(&text))? {
            rows.iter_mut().zip(&done).for_each(|(row, done)| row.join(done));
        }
        Ok(Self(rows))
    }

    /// All rows as one.
    #[must_use]
    pub fn all(&self) -> Row {
        let mut all = Row::default();
        self.0.iter().for_each(|row| all.join(row));
        all
    }
}

fn empty() -> Vec<Row> {
    let speed = |i: usize| 0.02 + 0.13 * i as f64 / (SPEEDS - 1) as f64;
    (0..SPEEDS).map(|i| Row { speed: speed(i), ..Row::default() }).collect()
}

impl fmt::Display for Summary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "   belt  parts  sorted  missed  wrong  faults    off centre [mm]     slip [mm/s]    speed"
        )?;
        writeln!(f, "    m/s                                        p50    p95    max     p95    max")?;
        let line = |f: &mut fmt::Formatter<'_>, name: &str, row: &Row| {
            let [p50, p95, most] = [0.5, 0.95, 1.0].map(|share| 1e3 * quantile(&row.off, share));
            let [slip, fastest] = [0.95, 1.0].map(|share| 1e3 * quantile(&row.slip, share));
            writeln!(
                f,
                "{name:>7}{:7}{:8}{:8}{:7}{:8}{p50:8.2}{p95:7.2}{most:7.2}{slip:8.2}{fastest:7.2}{:7.0} x",
                row.parts,
                row.sorted,
                row.missed,
                row.wrong,
                row.faults,
                row.pace()
            )
        };
        for row in self.0.iter().filter(|row| row.parts > 0) {
            line(f, &format!("{:.2}", row.speed), row)?;
        }
        let all = self.all();
        if self.0.len() > 1 {
            line(f, "all", &all)?;
        }
        writeln!(
            f,
            "fingers came down on a part {} times, and closed on nothing and were opened again {} times; speed: times faster than \
             real time, each run on one processor",
            all.crashes, all.failed
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_run_is_well_where_parts_are_sorted_and_none_wrongly() {
        let sorted = Row { parts: 3, sorted: 1, missed: 2, ..Row::default() };
        assert!(sorted.is_well());
        let wrong = Row { wrong: 1, ..sorted.clone() };
        let touched = Row { crashes: 1, ..sorted.clone() };
        let ended = Row { faults: 1, ..sorted.clone() };
        let missed = Row { sorted: 0, missed: 3, ..sorted };
        assert!([wrong, touched, ended, missed].iter().all(|row| !row.is_well()));
    }

    #[test]
    fn quantiles_are_values_that_so_many_do_not_exceed() {
        let values: Vec<f64> = (1..=100).rev().map(f64::from).collect();
        assert_eq!(
            (quantile(&values, 0.95), quantile(&values, 0.5), quantile(&values, 1.0)),
            (95.0, 50.0, 100.0)
        );
        assert_eq!((quantile(&[], 0.5), quantile(&[3.0], 0.01)), (0.0, 3.0));
    }
}
