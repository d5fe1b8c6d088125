//! One run: a maze, a seed.

use core::time::Duration;
use std::cell::{self, RefCell};
use std::rc::Rc;
use std::time::Instant;

use mrroc::cell::RunReport;
use mrroc::prelude::*;
use mrroc_map::{Contact, Inflated, Knowledge, Layout, Map, Place, Region};

use crate::force::sensor::{WallForce, Wrist};
use crate::mp::MazeSettings;
use crate::options::Means;
use crate::places::Sizes;
use crate::plant::{Plant, TouchProbe};
use crate::{ecp, file, force, found, mp, reactive, wheels};
use mrroc_robots::Irp6;

/// What came of a run.
#[derive(Debug)]
pub struct Outcome {
    /// Steps and simulated time, or the fault that ended it.
    pub report: Result<RunReport, CellError>,
    /// How long it took.
    pub wall: Duration,
    /// The distance that the ball has gone from the start on, and the shortest one \[m\]; 0 if there is none.
    pub distance: f64,
    /// See `distance`.
    pub shortest: f64,
    /// How many touches there were between the walls, or how many places of walls were seen.
    pub touches: usize,
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
    /// Touches that a force sensor counted, those of the frame from outside included.
    felt: Option<Rc<cell::Cell<u32>>>,
}

/// What is told of a maze with these sizes.
#[must_use]
pub fn told(maze: &Layout, sizes: &Sizes) -> MazeSettings {
    let goal = maze.goal();
    let at = |(x, y): (usize, usize), off: f64| Place::new(x as f64 + off, y as f64 + off) * sizes.pitch;
    let within = Place::new(sizes.within, sizes.within);
    MazeSettings {
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
        let program = |mp: &mut Mp, told: &MazeSettings, grown: &Rc<RefCell<Map>>| {
            mp::coordinate::<Irp6, TouchProbe>(mp, ["arm", "probe"], told, found::by_three_touches, grown)
        };
        Self::of(maze, seed, &file()?, sense, ecp::arm, program)
    }

    /// A cell with this maze and a force sensor, which `fail` may change.
    ///
    /// # Errors
    /// What is wrong with the cell's file.
    pub fn by_force<V: VirtualSensor<Kind = WallForce>>(
        maze: &Layout,
        seed: u64,
        fail: impl FnOnce(Wrist) -> V,
    ) -> Result<Self, CellError> {
        let file = CellFile::parse("cell.toml", include_str!("force/cell.toml"))?;
        let mut touches = None;
        let sense = |plant: &Plant, file: &CellFile, cell: Cell| {
            let wrist = Wrist::new(plant.world(), seed);
            touches = Some(wrist.touches());
            Ok(cell.sensor(file.sensor("force", fail(wrist))?))
        };
        let program = |mp: &mut Mp, told: &MazeSettings, grown: &Rc<RefCell<Map>>| {
            mp::coordinate::<Irp6, WallForce>(mp, ["arm", "force"], told, found::by_three_touches, grown)
        };
        let ready = Self::of(maze, seed, &file, sense, force::ecp::arm, program)?;
        Ok(Self { felt: touches, ..ready })
    }

    fn of(
        maze: &Layout,
        seed: u64,
        file: &CellFile,
        sense: impl FnOnce(&Plant, &CellFile, Cell) -> Result<Cell, CellError>,
        arm: impl Fn(&mut Ecp<Irp6>, &Sizes) -> Result<(), Fault> + 'static,
        program: impl Fn(&mut Mp, &MazeSettings, &Rc<RefCell<Map>>) -> Result<(), Fault> + 'static,
    ) -> Result<Self, CellError> {
        let sizes = Sizes::within_reach(maze);
        let plant = Plant::new(maze, &sizes, seed);
        let cell = sense(&plant, file, file.cell(&plant.kinds())?)?;
        let told = told(maze, &sizes);
        let walls = plant.world().borrow().walls.clone();
        let shortest = Inflated::by(&walls, sizes.radius)
            .shortest(&told.start, &told.goal)
            .map_or(0.0, |(length, _)| length);
        let map = Rc::new(RefCell::new(Map::new(told.known)));
        let grown = Rc::clone(&map);
        let cell = cell.ecp("arm", move |ecp| arm(ecp, &sizes)).program(move |mp| program(mp, &told, &grown));
        Ok(Self { cell, plant, map, shortest, sizes, felt: None })
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
            distance: world.stylus.distance,
            shortest: self.shortest,
            // Three were of the frame.
            touches: match self.felt {
                Some(felt) => felt.get().saturating_sub(3) as usize,
                None => self.map.borrow().contacts().len(),
            },
            contacts: self.map.borrow().contacts().to_vec(),
            travel: world.stylus.most,
            trace: world.trace.clone(),
            sizes: self.sizes,
        }
    }
}

/// Runs a maze.
///
/// # Errors
/// What is wrong with the cell's file.
pub fn solve(means: Means, maze: &Layout, seed: u64) -> Result<Outcome, CellError> {
    match means {
        Means::Wheels => wheels::run::Ready::new(maze, seed).map(wheels::run::Ready::run),
        Means::Probe => Ready::new(maze, seed).map(Ready::run),
        Means::Force => Ready::by_force(maze, seed, |wrist| wrist).map(Ready::run),
        Means::Reactive => reactive::run::Ready::new(maze, seed).map(reactive::run::Ready::run),
    }
}

impl Outcome {
    /// Its distance divided by the shortest one.
    #[must_use]
    pub fn ratio(&self) -> f64 {
        self.distance / self.shortest
    }
}
