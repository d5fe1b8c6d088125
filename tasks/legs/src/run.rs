//! One run: a seed.

use core::time::Duration;
use std::rc::Rc;
use std::time::Instant;

use mrroc::cell::RunReport;
use mrroc::prelude::*;

use crate::plant::{Drawn, ForceCells, Inclinometer, Plant};
use crate::seen::RunMeasurements;
use crate::walk::Gait;
use crate::{file, mp};

/// How long the steps are on which it walks, after level ground \[m\].
pub const LENGTH: f64 = 2.4;

/// What came of a run.
#[derive(Debug)]
pub struct Outcome {
    /// Steps and simulated time, or the fault that ended it.
    pub report: Result<RunReport, CellError>,
    /// How long it took.
    pub wall: Duration,
    /// What there was to see.
    pub seen: RunMeasurements,
}

/// A cell that is ready to run.
pub struct Ready {
    /// The cell.
    pub cell: Cell,
    /// Its world.
    pub plant: Plant,
}

impl Ready {
    /// A cell with what is drawn, and this gait.
    ///
    /// # Errors
    /// What is wrong with the cell's file.
    pub fn new(drawn: &Drawn, gait: &Gait, seed: u64) -> Result<Self, CellError> {
        let file = file()?;
        let plant = Plant::new(drawn);
        let cell = file
            .cell(&plant.kinds())?
            .sensor(file.sensor("feet", ForceCells::new(plant.world(), seed))?)
            .sensor(file.sensor("level", Inclinometer::new(plant.world(), seed))?);
        let (gait, ground) = (*gait, Rc::new(drawn.told.clone()));
        let cell = cell.program(move |mp| mp::coordinate(mp, &gait, &ground));
        Ok(Self { cell, plant })
    }

    /// Runs it.
    #[must_use]
    pub fn run(self) -> Outcome {
        let began = Instant::now();
        let report = self.cell.run();
        let wall = began.elapsed();
        let world = self.plant.world();
        let seen = world.borrow().seen.clone();
        Outcome { report, wall, seen }
    }
}
