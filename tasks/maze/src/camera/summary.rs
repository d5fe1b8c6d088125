//! What many runs with the camera came to.

use core::fmt;

use super::run::{Outcome, Ready};
use crate::mazes::Seeded;
use crate::summary::quantile;

/// A run, in figures.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Row {
    /// Which maze.
    pub name: String,
    /// The ball's distance through the shortest one.
    pub ratio: f64,
    /// The planned distance through the shortest one.
    pub planned: f64,
    /// How near the ball came to a wall, and how far a wall bent the stylus \[m\].
    pub clearance: f64,
    /// See `clearance`.
    pub travel: f64,
    /// From the image to the path, by the clock on the wall \[s\].
    pub image_to_path: f64,
    /// Simulated time, and time of the clock on the wall \[s\].
    pub time: f64,
    /// See `time`.
    pub wall: f64,
    /// The fault that ended it.
    pub fault: Option<String>,
}

/// Many of them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Summary(pub Vec<Row>);

impl Row {
    /// Of this run.
    #[must_use]
    pub fn of(name: &str, outcome: &Outcome) -> Self {
        let planned = outcome.planned.path.as_ref().map_or(0.0, mrroc_map::Taut::length);
        Self {
            name: name.to_owned(),
            ratio: outcome.ratio(),
            planned: planned / outcome.shortest,
            clearance: outcome.clearance,
            travel: outcome.travel,
            image_to_path: outcome.image_to_path().as_secs_f64(),
            time: outcome.report.as_ref().map_or(0.0, |report| report.time.as_secs_f64()),
            wall: outcome.wall.as_secs_f64(),
            fault: outcome.report.as_ref().err().map(ToString::to_string),
        }
    }
}

impl Summary {
    /// Runs all these mazes.
    #[must_use]
    pub fn sweep(mazes: &[Seeded]) -> Self {
        let run = |maze: &Seeded| match Ready::new(&maze.layout, maze.seed) {
            Ok(ready) => Row::of(&maze.name, &ready.run()),
            Err(error) => Row { name: maze.name.clone(), fault: Some(error.to_string()), ..Row::default() },
        };
        Self(mazes.iter().map(run).collect())
    }

    /// Those that came to the exit.
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
                "{:<24} {:>10} {:>10} {:>12} {:>13} {:>8}",
                "maze", "distance", "planned", "clearance", "image to path", "time"
            )?;
            for row in &self.0 {
                if row.fault.is_some() {
                    writeln!(f, "{:<24} the exit was not reached", row.name)?;
                    continue;
                }
                writeln!(
                    f,
                    "{:<24} {:>8.4} x {:>8.4} x {:>9.3} mm {:>11.0} ms {:>6.1} s",
                    row.name,
                    row.ratio,
                    row.planned,
                    1e3 * row.clearance,
                    1e3 * row.image_to_path,
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
            "{} of {} mazes: the exit was reached; {} faults",
            self.found().count(),
            self.0.len(),
            self.faults()
        )?;
        for (name, figure) in
            [("distance", (|row| row.ratio) as fn(&Row) -> f64), ("planned", |row: &Row| row.planned)]
        {
            writeln!(
                f,
                "{name}, times the shortest: median {:.4}, p95 {:.4}, worst {:.4}; above 1.01 in {}",
                of(0.5, figure),
                of(0.95, figure),
                of(1.0, figure),
                self.found().filter(|row| figure(row) > 1.01).count()
            )?;
        }
        writeln!(
            f,
            "contacts in {}; nearest to a wall: median {:.3} mm, worst {:.3} mm",
            self.found().filter(|row| row.travel > 0.0).count(),
            1e3 * of(0.5, |row| row.clearance),
            1e3 * of(0.0, |row| row.clearance)
        )?;
        writeln!(
            f,
            "from image to path: median {:.0} ms, worst {:.0} ms",
            1e3 * of(0.5, |row| row.image_to_path),
            1e3 * of(1.0, |row| row.image_to_path)
        )?;
        writeln!(f, "{:.0} times faster than real time", sum(|row| row.time) / sum(|row| row.wall).max(1e-9))
    }
}
