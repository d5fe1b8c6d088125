//! Variants of the task, and a run of one.

use std::time::{Duration, Instant};

use mrroc::cell::RunReport;
use mrroc::prelude::*;

use crate::monitor::{CellMonitor, RunMeasurements};
use crate::places::{EDGES, TABLE_EDGES, polycrank_base, table};
use crate::plant::{Plant, calibration_error, drives};
use crate::{cell, clear, mp, sensed};

/// What the arms do it with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Variant {
    /// The arms' drives alone: nothing between the hands.
    Empty,
    /// A bar between the hands; Polycrank's base is where it is believed to be, or it is not.
    Bar {
        /// Whether the base is believed to be where it is.
        bases: Bases,
        /// Whether the wrists' sensors are used.
        sensors: Sensors,
    },
}

/// The bases of the arms.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Bases {
    /// Where programs believe that they are.
    Calibrated,
    /// Polycrank's is off by [`calibration_error`] from where the task's own cell.toml has it.
    Off,
}

/// The force sensors at the wrists.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sensors {
    /// Not asked.
    Unused,
    /// They keep the internal force low.
    Used,
}

/// A variant that is ready to run.
pub struct Ready {
    /// The cell.
    pub cell: Cell,
    /// What is in it besides robots.
    pub plant: Option<Plant>,
}

/// What came of a run.
pub struct Outcome {
    /// Steps and simulated time.
    pub report: RunReport,
    /// How long it took.
    pub wall: Duration,
}

impl Outcome {
    /// How many times faster than real time it was.
    #[must_use]
    pub fn speed(&self) -> f64 {
        self.report.time.as_secs_f64() / self.wall.as_secs_f64()
    }
}

impl Variant {
    /// The cell of the file for this variant.
    ///
    /// # Errors
    /// What is wrong with the file.
    pub fn ready(self, file: &CellFile) -> Result<Ready, CellError> {
        let Variant::Bar { bases, sensors } = self else {
            let cell = cell(file, &drives())?.program(mp::coordinate);
            return Ok(Ready { cell, plant: None });
        };
        let error = match bases {
            Bases::Calibrated => Pose::identity(),
            Bases::Off => calibration_error(),
        };
        let mut plant = Plant::new(error).map_err(|bad| Fault::thrown(&bad.to_string()))?;
        if bases == Bases::Off {
            // It stays there when another cell's file believes better.
            plant = plant.with_base(polycrank_base() * error);
        }
        let world = plant.world.clone();
        let cell = cell(file, &plant.kinds())?
            .shows_body("bar", EDGES, move || world.body().pose)
            .shows_body("table", TABLE_EDGES, table);
        let cell = match sensors {
            Sensors::Unused => cell.program(mp::coordinate),
            Sensors::Used => plant.with_wrists(cell).program(sensed::coordinate),
        };
        Ok(Ready { cell, plant: Some(plant) })
    }

    /// Runs it, unwatched.
    ///
    /// # Errors
    /// The first cause when the run ends with a fault.
    pub fn run(self, file: &CellFile) -> Result<Outcome, CellError> {
        let ready = self.ready(file)?;
        let began = Instant::now();
        let report = ready.cell.run()?;
        Ok(Outcome { report, wall: began.elapsed() })
    }

    /// Runs it, and tells what was seen; `also` may add more that watches.
    ///
    /// # Errors
    /// The first cause when the run ends with a fault.
    pub fn watched(
        self,
        file: &CellFile,
        also: impl FnOnce(Cell, Option<&Plant>) -> Cell,
    ) -> Result<RunMeasurements, CellError> {
        let Ready { cell, plant } = self.ready(file)?;
        let monitor = CellMonitor::new();
        let guard = clear::guard(file, clear::MARGINS)?;
        also(monitor.watch(cell, plant.as_ref(), guard), plant.as_ref()).run()?;
        Ok(monitor.into_seen())
    }
}
