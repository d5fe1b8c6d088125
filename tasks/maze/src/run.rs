//! One run: a maze, a seed.

use core::time::Duration;
use std::cell::RefCell;
use std::rc::Rc;
use std::time::Instant;

use mrroc::cell::RunReport;
use mrroc::prelude::*;
use mrroc_map::{Contact, Inflated, Knowledge, Layout, Map, Place, Region};

use crate::mp::Told;
use crate::places::{BALL, PITCH, THICKNESS};
use crate::plant::Plant;
use crate::{ecp, file, mp};

/// The ball is in the goal when it is so far within its cells \[m\].
const WITHIN: f64 = 4e-3;

/// What came of a run.
#[derive(Debug)]
pub struct Outcome {
    /// Steps and simulated time, or the fault that ended it.
    pub report: Result<RunReport, CellError>,
    /// How long it took.
    pub wall: Duration,
    /// The ball's way from the start on, and the shortest one \[m\]; 0 if there is none.
    pub way: f64,
    /// See `way`.
    pub shortest: f64,
    /// What was touched.
    pub contacts: Vec<Contact>,
    /// The largest deflection of the stylus \[m\].
    pub travel: f64,
    /// The ball's places [m, M].
    pub trace: Vec<Place>,
}

/// A cell that is ready to run.
pub struct Ready {
    /// The cell.
    pub cell: Cell,
    /// Its world.
    pub plant: Plant,
    map: Rc<RefCell<Map>>,
    shortest: f64,
}

/// The goal of a maze [m, M].
#[must_use]
pub fn goal(maze: &Layout) -> Region {
    let goal = maze.goal();
    let within = Place::new(WITHIN, WITHIN);
    Region {
        lower: Place::new(goal.lower.0 as f64, goal.lower.1 as f64) * PITCH + within,
        upper: Place::new(goal.upper.0 as f64 + 1.0, goal.upper.1 as f64 + 1.0) * PITCH - within,
    }
}

/// The start of a maze: the middle of its cell [m, M].
#[must_use]
pub fn start(maze: &Layout) -> Place {
    Place::new(maze.start().0 as f64 + 0.5, maze.start().1 as f64 + 0.5) * PITCH
}

impl Ready {
    /// A cell with this maze.
    ///
    /// # Errors
    /// What is wrong with the cell's file.
    pub fn new(maze: &Layout, seed: u64) -> Result<Self, CellError> {
        Self::sensed_by(maze, seed, |plant, file, cell| Ok(cell.sensor(file.sensor("probe", plant.probe())?)))
    }

    /// A cell with this maze and another sensor, which `sense` puts into it.
    ///
    /// # Errors
    /// What is wrong with the cell's file.
    pub fn sensed_by(
        maze: &Layout,
        seed: u64,
        sense: impl FnOnce(&Plant, &CellFile, Cell) -> Result<Cell, CellError>,
    ) -> Result<Self, CellError> {
        let file = file()?;
        let plant = Plant::new(maze, seed);
        let cell = sense(&plant, &file, file.cell(&plant.kinds())?)?;
        let told = Told { start: start(maze), goal: goal(maze), most: 40 * maze.columns() * maze.rows() };
        let walls = plant.world().borrow().walls.clone();
        let shortest =
            Inflated::by(&walls, BALL).shortest(&told.start, &told.goal).map_or(0.0, |(length, _)| length);
        let map = Rc::new(RefCell::new(Map::new(Knowledge {
            size: [maze.columns() as f64 * PITCH, maze.rows() as f64 * PITCH],
            radius: BALL,
            thickness: THICKNESS,
            passage: 0.015,
            wall: 0.025,
        })));
        let grown = Rc::clone(&map);
        let cell = cell.ecp("arm", ecp::arm).program(move |mp| mp::coordinate(mp, &told, &grown));
        Ok(Self { cell, plant, map, shortest })
    }

    /// Runs it.
    #[must_use]
    pub fn run(self) -> Outcome {
        let began = Instant::now();
        let report = self.cell.run();
        let wall = began.elapsed();
        let world = self.plant.world();
        let world = world.borrow();
        Outcome {
            report,
            wall,
            way: world.stylus.way,
            shortest: self.shortest,
            contacts: self.map.borrow().contacts().to_vec(),
            travel: world.stylus.most,
            trace: world.trace.clone(),
        }
    }
}

impl Outcome {
    /// How many times the shortest way its way is.
    #[must_use]
    pub fn ratio(&self) -> f64 {
        self.way / self.shortest
    }
}
