//! One run of the reactive controller: walls, a seed.

use std::cell::RefCell;
use std::rc::Rc;
use std::time::Instant;

use mrroc::prelude::*;
use mrroc_map::{Contact, Inflated, Layout, Walls};

use super::sensor::Seeker;
use super::{ecp, mp};
use crate::mp::MazeSettings;
use crate::places::Sizes;
use crate::plant::Plant;
use crate::run::{Outcome, told};

/// A cell that is ready to run.
pub struct Ready {
    /// The cell.
    pub cell: Cell,
    /// Its world.
    pub plant: Plant,
    touched: Rc<RefCell<Vec<Contact>>>,
    shortest: f64,
    sizes: Sizes,
}

impl Ready {
    /// A cell with this maze.
    ///
    /// # Errors
    /// What is wrong with the cell's file.
    pub fn new(maze: &Layout, seed: u64) -> Result<Self, CellError> {
        let sizes = Sizes::within_reach(maze);
        Self::among(Walls::of(maze, sizes.pitch, sizes.thickness), told(maze, &sizes), seed)
    }

    /// A cell with any walls in a frame, of which `told` is told.
    ///
    /// # Errors
    /// What is wrong with the cell's file.
    pub fn among(walls: Walls, told: MazeSettings, seed: u64) -> Result<Self, CellError> {
        let file = CellFile::parse("cell.toml", include_str!("cell.toml"))?;
        let sizes = told.sizes;
        let shortest = Inflated::by(&walls, sizes.radius)
            .shortest(&told.start, &told.goal)
            .map_or(0.0, |(length, _)| length);
        let plant = Plant::among(walls, told.known.size, &sizes, seed);
        let seeker = Seeker::new(plant.world(), sizes.pitch);
        let touched = seeker.touched();
        let cell = file
            .cell(&plant.kinds())?
            .sensor(file.sensor("probe", plant.probe())?)
            .sensor(file.sensor("way", seeker)?)
            .ecp("arm", move |ecp| ecp::arm(ecp, &sizes))
            .program(move |mp| mp::coordinate(mp, &told));
        Ok(Self { cell, plant, touched, shortest, sizes })
    }

    /// Runs it.
    #[must_use]
    pub fn run(self) -> Outcome {
        let began = Instant::now();
        let report = self.cell.run();
        let wall = began.elapsed();
        let world = self.plant.world();
        let world = world.borrow();
        let contacts = self.touched.take();
        Outcome {
            report,
            wall,
            distance: world.stylus.distance,
            shortest: self.shortest,
            touches: contacts.len(),
            contacts,
            travel: world.stylus.most,
            trace: world.trace.clone(),
            sizes: self.sizes,
        }
    }
}
