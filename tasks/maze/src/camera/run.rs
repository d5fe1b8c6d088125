//! One run with the camera: a maze, a seed.

use core::time::Duration;
use std::cell::RefCell;
use std::rc::Rc;
use std::time::Instant;

use mrroc::cell::RunReport;
use mrroc::cell_file::CellFile;
use mrroc::prelude::*;
use mrroc_map::{Inflated, Layout, Place, Walls};

use super::mp::Planned;
use super::sensor::{OverMaze, Taken};
use super::{ecp, mp};
use crate::places::Sizes;
use crate::plant::Plant;
use crate::run::told;

/// A cell that is ready to run.
pub struct Ready {
    /// The cell.
    pub cell: Cell,
    /// Its world.
    pub plant: Plant,
    taken: Rc<RefCell<Taken>>,
    planned: Rc<RefCell<Planned>>,
    shortest: f64,
    sizes: Sizes,
}

/// What came of a run.
#[derive(Debug)]
pub struct Outcome {
    /// Steps and simulated time, or the fault that ended it.
    pub report: Result<RunReport, CellError>,
    /// How long it took.
    pub wall: Duration,
    /// The distance that the ball has gone, and the shortest one \[m\]; 0 if there is none.
    pub distance: f64,
    /// See `distance`.
    pub shortest: f64,
    /// The largest deflection of the stylus \[m\].
    pub travel: f64,
    /// How near the ball came to a wall \[m\].
    pub clearance: f64,
    /// The image and its walls.
    pub taken: Taken,
    /// The path that was planned.
    pub planned: Planned,
    /// The ball's places [m, M].
    pub trace: Vec<Place>,
    /// The walls as they are.
    pub walls: Walls,
}

impl Ready {
    /// A cell with this maze.
    ///
    /// # Errors
    /// What is wrong with the cell's file.
    pub fn new(maze: &Layout, seed: u64) -> Result<Self, CellError> {
        Self::seen_by(maze, seed, |camera| camera)
    }

    /// A cell with this maze, and its camera changed.
    ///
    /// # Errors
    /// What is wrong with the cell's file.
    pub fn seen_by(
        maze: &Layout,
        seed: u64,
        change: impl FnOnce(OverMaze) -> OverMaze,
    ) -> Result<Self, CellError> {
        let file = CellFile::parse("cell.toml", include_str!("cell.toml"))?;
        let sizes = Sizes::within_reach(maze);
        let plant = Plant::new(maze, &sizes, seed);
        let camera = change(OverMaze::new(plant.clone(), &sizes, sizes.sides(maze), seed));
        let taken = camera.taken();
        let told = told(maze, &sizes);
        let shortest = {
            let world = plant.world();
            let world = world.borrow();
            Inflated::by(&world.walls, sizes.radius)
                .shortest(&told.start, &told.goal)
                .map_or(0.0, |(length, _)| length)
        };
        let planned = Rc::<RefCell<Planned>>::default();
        let plans = Rc::clone(&planned);
        let cell = file
            .cell(&plant.kinds())?
            .sensor(file.sensor("probe", plant.probe())?)
            .sensor(file.sensor("camera", camera)?)
            .ecp("arm", move |ecp| ecp::arm(ecp, &sizes))
            .program(move |mp| mp::coordinate(mp, &told, &plans));
        Ok(Self { cell, plant, taken, planned, shortest, sizes })
    }

    /// Runs it.
    #[must_use]
    pub fn run(self) -> Outcome {
        let began = Instant::now();
        let report = self.cell.run();
        let wall = began.elapsed();
        let world = self.plant.world();
        let world = world.borrow();
        let near = |at: &Place| world.walls.clearance(at) - self.sizes.radius;
        Outcome {
            report,
            wall,
            distance: world.stylus.distance,
            shortest: self.shortest,
            travel: world.stylus.most,
            clearance: world.trace.iter().map(near).fold(f64::INFINITY, f64::min),
            taken: self.taken.take(),
            planned: self.planned.take(),
            trace: world.trace.clone(),
            walls: world.walls.clone(),
        }
    }
}

impl Outcome {
    /// Its distance divided by the shortest one.
    #[must_use]
    pub fn ratio(&self) -> f64 {
        self.distance / self.shortest
    }

    /// From the image to the motion along the path.
    #[must_use]
    pub const fn image_to_path(&self) -> Duration {
        self.taken.took.saturating_add(self.planned.took)
    }
}
