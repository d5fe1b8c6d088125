//! What many runs came to.

use core::fmt;
use std::panic::resume_unwind;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;

use mrroc_map::Layout;

use crate::mazes::Seeded;
use crate::options::Means;
use crate::run::{Outcome, solve};

/// A run, in figures.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// Which maze.
    pub name: String,
    /// The ball's distance through the shortest one.
    pub ratio: f64,
    /// How many touches.
    pub touches: usize,
    /// The largest deflection of the stylus \[m\].
    pub travel: f64,
    /// Simulated time, and time of the clock on the wall \[s\].
    pub time: f64,
    /// See `time`.
    pub wall: f64,
    /// Whether the left-hand rule gets there without a map, in cells.
    pub by_hand: bool,
    /// The fault that ended it.
    pub fault: Option<String>,
}

/// Many of them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Summary(pub Vec<Row>);

/// The `share` quantile, the lower one between two; 0 of nothing.
#[must_use]
pub fn quantile(values: impl IntoIterator<Item = f64>, share: f64) -> f64 {
    let mut values: Vec<f64> = values.into_iter().collect();
    values.sort_by(f64::total_cmp);
    let last = values.len().saturating_sub(1);
    values.get((share * last as f64).floor() as usize).copied().unwrap_or(0.0)
}

impl Row {
    fn by_running(means: Means, maze: &Seeded) -> Self {
        match solve(means, &maze.layout, maze.seed) {
            Ok(outcome) => Self::of(&maze.name, &maze.layout, &outcome),
            Err(error) => Self {
                name: maze.name.clone(),
                ratio: 0.0,
                touches: 0,
                travel: 0.0,
                time: 0.0,
                wall: 0.0,
                by_hand: false,
                fault: Some(error.to_string()),
            },
        }
    }

    /// Of this run.
    #[must_use]
    pub fn of(name: &str, maze: &Layout, outcome: &Outcome) -> Self {
        Self {
            name: name.to_owned(),
            ratio: outcome.ratio(),
            touches: outcome.touches,
            travel: outcome.travel,
            time: outcome.report.as_ref().map_or(0.0, |report| report.time.as_secs_f64()),
            wall: outcome.wall.as_secs_f64(),
            by_hand: maze.cells_by_the_left_hand().is_some(),
            fault: outcome.report.as_ref().err().map(ToString::to_string),
        }
    }
}

impl Summary {
    /// Runs all these mazes on all processors.
    #[must_use]
    pub fn sweep(means: impl Into<Means>, mazes: &[Seeded]) -> Self {
        let means = means.into();
        let next = AtomicUsize::new(0);
        let worker = || {
            let mut rows = vec![];
            loop {
                let number = next.fetch_add(1, Ordering::Relaxed);
                let Some(maze) = mazes.get(number) else { return rows };
                rows.push((number, Row::by_running(means, maze)));
            }
        };
        let count = thread::available_parallelism().map_or(1, usize::from);
        let mut rows: Vec<(usize, Row)> = thread::scope(|scope| {
            let workers: Vec<_> = (0..count.min(mazes.len())).map(|_| scope.spawn(worker)).collect();
            let rows = workers
                .into_iter()
                .flat_map(|worker| worker.join().unwrap_or_else(|panic| resume_unwind(panic)));
            rows.collect()
        });
        rows.sort_by_key(|(number, _)| *number);
        Self(rows.into_iter().map(|(_, row)| row).collect())
    }

    /// Those that found the exit.
    pub fn found(&self) -> impl Iterator<Item = &Row> {
        self.0.iter().filter(|row| row.fault.is_none())
    }

    /// How many ended with a fault.
    #[must_use]
    pub fn faults(&self) -> usize {
        self.0.len() - self.found().count()
    }
}

impl fmt::Display for Summary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.0.len() <= 30 {
            writeln!(
                f,
                "{:<24} {:>9} {:>8} {:>10} {:>9} {:>10}",
                "maze", "distance", "touches", "travel", "time", "left hand"
            )?;
            for row in &self.0 {
                if row.fault.is_some() {
                    writeln!(f, "{:<24} the exit was not found, after {} touches", row.name, row.touches)?;
                    continue;
                }
                let hand = if row.by_hand { "gets there" } else { "goes round" };
                writeln!(
                    f,
                    "{:<24} {:>7.2} x {:>8} {:>7.2} mm {:>7.1} s {hand:>10}",
                    row.name,
                    row.ratio,
                    row.touches,
                    1e3 * row.travel,
                    row.time
                )?;
            }
        }
        for row in &self.0 {
            if let Some(fault) = &row.fault {
                writeln!(f, "{}: {fault}", row.name)?;
            }
        }
        let of = |share: f64, figure: fn(&Row) -> f64| quantile(self.found().map(figure), share);
        let sum = |figure: fn(&Row) -> f64| self.found().map(figure).sum::<f64>();
        writeln!(
            f,
            "{} of {} mazes: the exit was found; {} faults",
            self.found().count(),
            self.0.len(),
            self.faults()
        )?;
        writeln!(
            f,
            "distance, times the shortest: median {:.2}, p95 {:.2}, worst {:.2}",
            of(0.5, |row| row.ratio),
            of(0.95, |row| row.ratio),
            of(1.0, |row| row.ratio)
        )?;
        let (median, p95) = (of(0.5, |row| row.touches as f64), of(0.95, |row| row.touches as f64));
        match 1e3 * of(1.0, |row| row.travel) {
            0.0 => {
                writeln!(f, "places of walls that were seen: median {median}, p95 {p95}; none was touched")?
            }
            bent => writeln!(
                f,
                "touches: median {median}, p95 {p95}; stylus bent by at most {bent:.2} mm of 4 mm"
            )?,
        }
        let hands = self.0.iter().filter(|row| row.by_hand).count();
        writeln!(f, "without a map the left-hand rule gets to {hands} of {}", self.0.len())?;
        writeln!(
            f,
            "{:.0} times faster than real time, on each processor",
            sum(|row| row.time) / sum(|row| row.wall).max(1e-9)
        )
    }
}
