//! What the simulated arm and the probe do in: walls, and a stylus among them.

mod arm;
mod probe;
pub mod stylus;

use std::cell::RefCell;
use std::rc::Rc;

use mrroc::cell_file::Kinds;
use mrroc::prelude::*;
use mrroc::random::Random;
use mrroc_map::{Layout, Walls};
use mrroc_robots::{Irp6, SimulatedIrp6};
use nalgebra::Vector3;

pub use arm::{Probing, World, probing};
pub use probe::{Probe, TouchProbe};

use crate::places::{LOOSE, Sizes, TURNED, said};
use stylus::Stylus;

/// The world of the cell.
#[derive(Clone, Debug)]
pub struct Plant(Rc<RefCell<World>>);

impl Plant {
    /// A maze that stands to [`LOOSE`] and [`TURNED`] where it is said to, by chance.
    #[must_use]
    pub fn new(maze: &Layout, sizes: &Sizes, seed: u64) -> Self {
        let walls = Walls::of(maze, sizes.pitch, sizes.thickness);
        Self::among(walls, sizes.sides(maze), sizes, seed)
    }

    /// Walls in a frame of these sides \[m\], which stand as loosely.
    #[must_use]
    pub fn among(walls: Walls, size: [f64; 2], sizes: &Sizes, seed: u64) -> Self {
        let mut chance = Random::seeded(seed ^ 0x6d61_7a65);
        let middle = Pose::translation(0.5 * size[0], 0.5 * size[1], 0.0);
        let off = Pose::translation(chance.within(LOOSE), chance.within(LOOSE), 0.0)
            * Pose::rotation(Vector3::z() * chance.within(TURNED));
        let world = World {
            X_WM: said(size) * middle * off * middle.inverse(),
            walls,
            stylus: Stylus::new(sizes.radius, seed),
            time: 0.0,
            onset: 0.0,
            last: 0.0,
            trace: Vec::new(),
        };
        Self(Rc::new(RefCell::new(world)))
    }

    /// What arm and probe share.
    #[must_use]
    pub fn world(&self) -> Rc<RefCell<World>> {
        Rc::clone(&self.0)
    }

    /// The kinds of `cell.toml`, with drives in this world.
    #[must_use]
    pub fn kinds(&self) -> Kinds {
        let world = self.world();
        Kinds::new().with("arm", move |entry| {
            let robot = Irp6::nominal().with_base(entry.base());
            let drives = SimulatedIrp6::new(robot.clone(), &entry.start(&robot)?);
            let drives = probing(drives, entry.tool(), Rc::clone(&world));
            Ok(RobotSetup::new(entry.name(), robot, drives))
        })
    }

    /// The probe.
    #[must_use]
    pub fn probe(&self) -> Probe {
        Probe::new(self.world())
    }
}
