//! The simulated base in its maze: put down at the start as a person does, and its sensor.

use std::cell::RefCell;
use std::rc::Rc;

use mrroc::cell_file::Kinds;
use mrroc::prelude::*;
use mrroc::random::Random;
use mrroc_map::{Knowledge, Layout, Place, Side, Walls};
use mrroc_wheels::sensing::infrared::SENSORS;
use mrroc_wheels::sensing::{
    DeadReckoning, Gyro, Infrared, Located, LookingOut, Lookout, Sight, WallMemory, Watch,
};
use mrroc_wheels::simulation::{Floor, Ground};
use mrroc_wheels::{DiffDrive, Planar, Rolling};

use crate::places::Sizes;
use crate::run::told;

/// How far beside the middle of the start's cell it is put down at most \[m\], and how much it is turned \[rad\].
const PUT_DOWN: (f64, f64) = (3e-3, 0.017);

/// The world of a base.
#[derive(Clone, Debug)]
pub struct Plant {
    /// The floor with the maze and the base.
    pub floor: Floor,
    /// Where the base was [m, M].
    pub trace: Rc<RefCell<Vec<Place>>>,
    said: Planar,
    told: Knowledge,
    seed: u64,
}

impl Plant {
    /// A base at the start of a maze, turned to where that is open.
    #[must_use]
    pub fn new(maze: &Layout, sizes: &Sizes, seed: u64) -> Self {
        let mut chance = Random::seeded(seed ^ 0x7768_6c73);
        let (x, y) = maze.start();
        let open = Side::ALL.into_iter().position(|side| maze.next((x, y), side).is_some()).unwrap_or(0);
        let said = Planar {
            x: (x as f64 + 0.5) * sizes.pitch,
            y: (y as f64 + 0.5) * sizes.pitch,
            heading: core::f64::consts::FRAC_PI_2 * open as f64,
        };
        let truly = Planar {
            x: said.x + chance.within(PUT_DOWN.0),
            y: said.y + chance.within(PUT_DOWN.0),
            heading: said.heading + chance.within(PUT_DOWN.1),
        };
        let rims = [1.0 + chance.within(2e-3), 1.0 + chance.within(2e-3)];
        let walls = Some(Walls::of(maze, sizes.pitch, sizes.thickness));
        let floor = Floor::new(Ground { walls, rims, ..Ground::default() }, truly);
        let trace = Rc::new(RefCell::new(vec![truly.at()]));
        Self { floor, trace, said, told: told(maze, sizes).known, seed }
    }

    /// The kinds of `wheels.toml`, with drives in this world.
    #[must_use]
    pub fn kinds(&self) -> Kinds {
        let floor = self.floor.clone();
        Kinds::new().with("diff-drive", move |entry| {
            let drives = Rolling::new(DiffDrive::new(), floor.clone());
            Ok(RobotSetup::new(entry.name(), DiffDrive::new(), drives))
        })
    }

    /// The sensor.
    #[must_use]
    pub fn lookout(&self) -> Traced {
        let gyro = Gyro::new(self.floor.clone(), self.seed);
        let located = Located::by(gyro, DeadReckoning::from(self.said));
        let infrared = Infrared::new(self.floor.clone(), self.seed);
        let memory = WallMemory::of_frame(self.told, SENSORS);
        let inner = LookingOut::new(self.floor.clone(), located, infrared, memory);
        Traced { inner, floor: self.floor.clone(), trace: Rc::clone(&self.trace) }
    }
}

/// The sensor, which also leaves a trace of the base's true path, to be drawn.
#[derive(Debug)]
pub struct Traced {
    inner: LookingOut,
    floor: Floor,
    trace: Rc<RefCell<Vec<Place>>>,
}

impl Traced {
    /// The floor that the base is on, to compare with.
    #[must_use]
    pub const fn floor(&self) -> &Floor {
        &self.floor
    }

    /// What it is made of, to break it.
    pub const fn inner_mut(&mut self) -> &mut LookingOut {
        &mut self.inner
    }
}

impl VirtualSensor for Traced {
    type Kind = Lookout;

    fn aggregate(&mut self, order: &ReadingOrder<Watch>) -> Result<Sight, Fault> {
        let at = self.floor.motion().pose.at();
        let mut trace = self.trace.borrow_mut();
        if trace.last().is_none_or(|last| (at - last).norm() > 3e-3) {
            trace.push(at);
        }
        self.inner.aggregate(order)
    }

    fn is_simulated(&self) -> bool {
        true
    }
}
