//! One run: a maze, a seed.

use core::time::Duration;
use std::cell::RefCell;
use std::rc::Rc;
use std::time::Instant;

use mrroc::cell::RunReport;
use mrroc::prelude::*;
use mrroc_map::{Contact, Inflated, Knowledge, Layout, Map, Place, Region};

use crate::mp::Told;
use crate::options::EffectorKind;
use crate::places::Sizes;
use crate::plant::{Plant, TouchProbe};
use crate::{ecp, file, found, mp, wheels};
use mrroc_robots::Irp6;

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
    /// Of maze and ball.
    pub sizes: Sizes,
}

/// A cell that is ready to run.
pub struct Ready {
    /// The cell.
    pub cell: Cell,
    /// Its world.
    pub plant: Plant,
    map: Rc<RefCell<Map>>,
    shortest: f64,
    sizes: Sizes,
}

/// What is told of a maze with these sizes.
#[must_use]
pub fn told(maze: &Layout, sizes: &Sizes) -> Told {
    let goal = maze.goal();
    let at = |(x, y): (usize, usize), off: f64| Place::new(x as f64 + off, y as f64 + off) * sizes.pitch;
    let within = Place::new(sizes.within, sizes.within);
    Told {
        start: at(maze.start(), 0.5),
        goal: Region { lower: at(goal.lower, 0.0) + within, upper: at(goal.upper, 1.0) - within },
        most: 40 * maze.columns() * maze.rows(),
        known: Knowledge {
            size: sizes.sides(maze),
            radius: sizes.radius,
            thickness: sizes.thickness,
            passage: sizes.passage,
            wall: sizes.pitch,
        },
        sizes: *sizes,
    }
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
        let sizes = Sizes::within_reach(maze);
        let plant = Plant::new(maze, &sizes, seed);
        let cell = sense(&plant, &file, file.cell(&plant.kinds())?)?;
        let told = told(maze, &sizes);
        let walls = plant.world().borrow().walls.clone();
        let shortest = Inflated::by(&walls, sizes.radius)
            .shortest(&told.start, &told.goal)
            .map_or(0.0, |(length, _)| length);
        let map = Rc::new(RefCell::new(Map::new(told.known)));
        let grown = Rc::clone(&map);
        let cell = cell.ecp("arm", move |ecp| ecp::arm(ecp, &sizes)).program(move |mp| {
            mp::coordinate::<Irp6, TouchProbe>(mp, ["arm", "probe"], &told, found::by_three_touches, &grown)
        });
        Ok(Self { cell, plant, map, shortest, sizes })
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
            sizes: self.sizes,
        }
    }
}

/// Runs a maze with an effector.
///
/// # Errors
/// What is wrong with the cell's file.
pub fn solve(effector: EffectorKind, maze: &Layout, seed: u64) -> Result<Outcome, CellError> {
    match effector {
        EffectorKind::Arm => Ready::new(maze, seed).map(Ready::run),
        EffectorKind::Wheels => wheels::run::Ready::new(maze, seed).map(wheels::run::Ready::run),
    }
}

impl Outcome {
    /// How many times the shortest way its way is.
    #[must_use]
    pub fn ratio(&self) -> f64 {
        self.way / self.shortest
    }
}
