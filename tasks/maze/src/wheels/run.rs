//! One run of the base: a maze, a seed.

use std::cell::RefCell;
use std::rc::Rc;
use std::time::Instant;

use mrroc::prelude::*;
use mrroc_map::{Inflated, Layout, Map, Walls};
use mrroc_wheels::DiffDrive;
use mrroc_wheels::sensing::Lookout;

use super::plant::{Plant, Traced};
use super::{CONTEST, ecp};
use crate::mp;
use crate::orders::Task;
use crate::run::{Outcome, told};

/// A cell that is ready to run.
pub struct Ready {
    /// The cell.
    pub cell: Cell,
    /// Its world.
    pub plant: Plant,
    map: Rc<RefCell<Map>>,
    shortest: f64,
}

impl Ready {
    /// A cell with a base in this maze.
    ///
    /// # Errors
    /// What is wrong with the cell's file.
    pub fn new(maze: &Layout, seed: u64) -> Result<Self, CellError> {
        Self::sensed_by(maze, seed, |lookout| lookout)
    }

    /// A cell whose sensor is made of the usual one.
    ///
    /// # Errors
    /// What is wrong with the cell's file.
    pub fn sensed_by<V: VirtualSensor<Kind = Lookout>>(
        maze: &Layout,
        seed: u64,
        sense: impl FnOnce(Traced) -> V,
    ) -> Result<Self, CellError> {
        let file = CellFile::parse("wheels.toml", include_str!("wheels.toml"))?;
        let plant = Plant::new(maze, &CONTEST, seed);
        let told = told(maze, &CONTEST);
        let walls = Walls::of(maze, CONTEST.pitch, CONTEST.thickness);
        let shortest = Inflated::by(&walls, CONTEST.radius)
            .shortest(&told.start, &told.goal)
            .map_or(0.0, |(length, _)| length);
        let map = Rc::new(RefCell::new(Map::new(told.known)));
        let grown = Rc::clone(&map);
        let cell = file
            .cell(&plant.kinds())?
            .sensor(file.sensor("lookout", sense(plant.lookout()))?)
            .ecp("base", move |ecp| ecp::base(ecp, &CONTEST))
            .program(move |mp| {
                // The frame of the maze is that of the floor: a base stands in it from the beginning.
                mp::coordinate::<DiffDrive, Lookout>(
                    mp,
                    ["base", "lookout"],
                    &told,
                    |have, told| Ok((Pose::identity(), have(Task::Go { x: told.start.x, y: told.start.y })?)),
                    &grown,
                )
            });
        Ok(Self { cell, plant, map, shortest })
    }

    /// Runs it.
    #[must_use]
    pub fn run(self) -> Outcome {
        let began = Instant::now();
        let report = self.cell.run();
        Outcome {
            report,
            wall: began.elapsed(),
            distance: self.plant.floor.travel(),
            shortest: self.shortest,
            touches: self.map.borrow().contacts().len(),
            contacts: self.map.borrow().contacts().to_vec(),
            travel: self.plant.floor.touched().deepest,
            trace: self.plant.trace.take(),
            sizes: CONTEST,
        }
    }
}
