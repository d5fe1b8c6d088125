//! One run: a belt, a seed, some parts.

use core::cell::Cell as Count;
use core::time::Duration;
use std::rc::Rc;
use std::time::Instant;

use mrroc::cell::RunReport;
use mrroc::prelude::*;

use crate::generators::{Chase, Open, Uneven};
use crate::monitor::{Fate, Grip, HandMonitor, fates};
use crate::mp::Failed;
use crate::parts::{Arrival, arrivals};
use crate::places::{END, SPACING};
use crate::plant::Plant;
use crate::{ecp, file, mp};

/// What is run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Nominal speed of the belt [m/s].
    pub speed: f64,
    /// Of parts, sensors and belt.
    pub seed: u64,
    /// How many parts come.
    pub parts: usize,
    /// Whether the arm is led by the first edge alone.
    pub sensing: Sensing,
    /// From when on \[s\] the belt goes at which share of its speed.
    pub profile: &'static [(f64, f64)],
}

/// What the arm is led by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sensing {
    /// All sensors.
    Reactive,
    /// The first edge of a part, and the nominal speed of the belt and the mean length of parts.
    FirstEdge,
}

/// A cell that is ready to run.
pub struct Ready {
    /// The cell.
    pub cell: Cell,
    /// Its world.
    pub plant: Plant,
    /// The parts that come.
    pub parts: Vec<Arrival>,
    /// Why parts were let pass.
    pub chase: Chase,
    failed: Rc<Count<Failed>>,
    monitor: HandMonitor,
}

/// What came of a run.
#[derive(Debug)]
pub struct Outcome {
    /// Steps and simulated time, or the fault that ended it.
    pub report: Result<RunReport, CellError>,
    /// How long it took.
    pub wall: Duration,
    /// What became of each part.
    pub fates: Vec<Fate>,
    /// The grasps.
    pub grips: Vec<Grip>,
    /// How often a finger came down on a part.
    pub crashes: u32,
    /// How often the hand closed on nothing, and was opened again.
    pub failed: u32,
}

impl Settings {
    /// One part, sensed.
    #[must_use]
    pub const fn one(speed: f64, seed: u64) -> Self {
        Self { speed, seed, parts: 1, sensing: Sensing::Reactive, profile: &[] }
    }

    /// When the first part comes \[s\]: the belt has its speed.
    #[must_use]
    pub fn first(&self) -> f64 {
        2.0 + (1.0 + Uneven::OFF) * self.speed / Uneven::ACCELERATION
    }

    /// The least time between parts \[s\]: the arm's, and so long that no two are between the barriers.
    fn gap(&self) -> f64 {
        f64::max(Self::CYCLE, 2.5 * SPACING / ((1.0 - Uneven::OFF) * self.speed))
    }

    /// Parts come so much later than they need to in the mean, as a share of the least time between them.
    const LATER: f64 = 0.2;

    /// The mean time between two parts \[s\].
    #[must_use]
    pub fn every(&self) -> f64 {
        (1.0 + Self::LATER) * self.gap()
    }

    /// The time that the arm needs for a part at most, from where it waits and back \[s\].
    pub const CYCLE: f64 = 10.0;

    /// The cell.
    ///
    /// # Errors
    /// What is wrong with the cell's file or a figure.
    pub fn ready(&self) -> Result<Ready, CellError> {
        self.sensed_by(|plant, file, cell| plant.sense(file, cell))
    }

    /// The cell with other sensors, which `sense` puts into it.
    ///
    /// # Errors
    /// What is wrong with the cell's file or a figure.
    pub fn sensed_by(
        &self,
        sense: impl FnOnce(&Plant, &CellFile, Cell) -> Result<Cell, CellError>,
    ) -> Result<Ready, CellError> {
        let file = file()?;
        let parts = arrivals(self.parts, self.first(), self.gap(), Self::LATER * self.gap(), self.seed);
        let wrong = |bad| Fault::thrown(&format!("{bad}"));
        let plant = Plant::new(&parts, self.seed.wrapping_mul(1000)).map_err(wrong)?;
        let cell = file.cell(&plant.kinds())?;
        let cell = sense(&plant, &file, cell)?;
        let open = (self.sensing == Sensing::FirstEdge).then_some(Open { speed: self.speed, length: 0.075 });
        let chase = Chase { open, ..Chase::default() };
        let arm = chase.clone();
        let slowest = (1.0 - 1.1 * Uneven::OFF) * self.speed;
        let timeout = 3.0 * self.gap() + (END + 2.0 * SPACING) / slowest + self.first();
        let Self { speed, seed, profile, parts: count, .. } = *self;
        let failed = Rc::<Count<Failed>>::default();
        let fails = Rc::clone(&failed);
        let cell =
            cell.ecp("arm", move |ecp| ecp::arm(ecp, &arm)).ecp("hand", ecp::hand).program(move |mp| {
                let belt = Uneven::about(speed, seed.wrapping_add(77)).changing(profile);
                mp::coordinate(mp, belt, (count as u32, timeout), &fails)
            });
        let hand = plant.world.hand(0).ok_or_else(|| Fault::thrown("the cell has no arm"))?;
        let monitor = HandMonitor::of(hand);
        let cell = cell.guard(1, monitor.look());
        Ok(Ready { cell, plant, parts, chase, failed, monitor })
    }

    /// Runs it.
    ///
    /// # Errors
    /// What is wrong with the cell's file or a figure; a fault of the run is part of its outcome.
    pub fn run(&self) -> Result<Outcome, CellError> {
        Ok(self.ready()?.run())
    }
}

impl Ready {
    /// Runs it.
    #[must_use]
    pub fn run(self) -> Outcome {
        let began = Instant::now();
        let report = self.cell.run();
        let wall = began.elapsed();
        let hand = self.plant.world.hand(0);
        Outcome {
            report,
            wall,
            fates: fates(&self.plant.world, &self.parts),
            grips: self.monitor.grips(),
            crashes: hand.map_or(0, |hand| hand.crashes()),
            failed: self.failed.get().all,
        }
    }
}

impl Outcome {
    /// How many parts had this fate.
    #[must_use]
    pub fn count(&self, fate: Fate) -> usize {
        self.fates.iter().filter(|of| **of == fate).count()
    }
}
