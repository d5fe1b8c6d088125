//! What the simulated robots do in, and what the sensors see: parts on a belt, fingers, trays, a bin at the end.

use std::cell::RefCell;
use std::rc::Rc;

use mrroc::cell_file::Kinds;
use mrroc::pose::Pose;
use mrroc::prelude::*;
use mrroc_robots::grasp::{self, Sink, World, WorldError};
use mrroc_robots::{Shaft, simulated_in_with};
use mrroc_sensors::aggregation::Laterals;
use mrroc_sensors::physics::{LightBarrier, Triangulation};
use mrroc_sensors::virtual_sensors::{FingerBarrier, GateSensor, RangeFinder};
use nalgebra::{Translation3, UnitQuaternion, Vector3};

use crate::parts::Arrival;
use crate::places::{BEAM, BEAMS, BELT, RANGE_AT, RANGE_FROM, SPACING, SURFACE, TRAY, TRAYS};
use crate::scene::{AtTool, Belt};

/// The sink at the end of the belt; the trays are those before it.
pub const END_BIN: usize = TRAYS.len();

/// The world of the cell.
#[derive(Clone, Debug)]
pub struct Plant {
    /// Parts, belt, trays, hand.
    pub world: World,
    scene: Belt,
    seed: u64,
    shaft: Rc<RefCell<Option<Shaft>>>,
    surface: [f64; 3],
}

impl Plant {
    /// With these parts to come; the seed is that of the sensors' noise.
    ///
    /// # Errors
    /// A figure of a part or of `places.rs` is out of range.
    pub fn new(parts: &[Arrival], seed: u64) -> Result<Self, WorldError> {
        let mut world = World::empty().with_rest();
        for [x, y, z] in TRAYS {
            let [dx, dy, dz] = TRAY.map(|edge| 0.5 * edge);
            world =
                world.with_sink(Sink { lower: [x - dx, y - dy, z - dz], upper: [x + dx, y + dy, z + dz] })?;
        }
        let below = Sink { lower: [-2.0, -2.0, -1.0], upper: [2.0, 2.0, -0.1] };
        world = world.with_sink(below)?;
        for part in parts {
            world.put_at(&part.body, part.time)?;
        }
        let scene = Belt::new(world.clone(), parts);
        Ok(Self::of(world, scene, seed))
    }

    /// A world that sensors see as `scene`; the seed is that of their noise.
    #[must_use]
    pub fn of(world: World, scene: Belt, seed: u64) -> Self {
        Self { world, scene, seed, shaft: Rc::default(), surface: SURFACE }
    }

    /// The same with a belt that is so much longer \[m\].
    #[must_use]
    pub fn with_belt_longer_by(mut self, length: f64) -> Self {
        self.surface[1] += length;
        self
    }

    /// The true joints of the first arm, once it is in the world.
    #[must_use]
    pub fn shaft(&self) -> Rc<RefCell<Option<Shaft>>> {
        self.shaft.clone()
    }

    /// The kinds of `cell.toml`, with drives in this world.
    #[must_use]
    pub fn kinds(&self) -> Kinds {
        let shaft = self.shaft();
        let [from, to, width] = self.surface;
        simulated_in_with(&self.world, grasp::Belt::new(from, to, width), move |_, drives| {
            shaft.borrow_mut().get_or_insert_with(|| drives.shaft());
        })
    }

    /// The cell with all sensors.
    ///
    /// # Errors
    /// What is wrong with their tables in the cell's file.
    pub fn sense(&self, file: &CellFile, cell: Cell) -> Result<Cell, CellError> {
        let step = file.step().as_secs_f64();
        let cell = cell.sensor(file.sensor("gate", self.gate(step))?);
        let cell = cell.sensor(file.sensor("range", self.range(step))?);
        Ok(cell.sensor(file.sensor("fingers", self.fingers(step))?))
    }

    /// The gate: its two barriers, which look across the belt.
    #[must_use]
    pub fn gate(&self, step: f64) -> GateSensor<Belt> {
        let beam = |s: f64| across(s, 0.5 * SURFACE[2], BEAMS);
        let barrier = |number: u64| LightBarrier::new(0.005, self.seed.wrapping_add(number));
        GateSensor::new(self.scene.clone(), [beam(-SPACING), beam(0.0)], [barrier(1), barrier(2)], step)
    }

    /// The range finder. Beyond the belt it sees a rail.
    #[must_use]
    pub fn range(&self, step: f64) -> RangeFinder<Belt> {
        let sensor = Triangulation::new(0.5, self.seed.wrapping_add(3));
        let laterals = Laterals::new(RANGE_FROM - 0.08, RANGE_FROM + 0.05, 70.0);
        RangeFinder::new(self.scene.clone(), across(RANGE_AT, RANGE_FROM, BEAMS), sensor, laterals, step)
    }

    /// The barrier between the fingers, from tip to tip.
    ///
    /// # Panics
    /// Before the arm is in the world: [`kinds`](Self::kinds).
    #[must_use]
    pub fn fingers(&self, step: f64) -> FingerBarrier<AtTool> {
        self.fingers_before(BEAM, step)
    }

    /// The barrier between the fingers, its beam so far before the middle of their pads \[m\].
    ///
    /// # Panics
    /// Before the arm is in the world: [`kinds`](Self::kinds).
    #[must_use]
    pub fn fingers_before(&self, ahead: f64, step: f64) -> FingerBarrier<AtTool> {
        self.fingers_of(0, ahead, step)
    }

    /// The same of an arm, counted from 0.
    ///
    /// # Panics
    /// Before the arm is in the world: [`kinds`](Self::kinds).
    #[must_use]
    pub fn fingers_of(&self, arm: usize, ahead: f64, step: f64) -> FingerBarrier<AtTool> {
        let hand = self.world.hand(arm).expect("the arm is in the world");
        // y of E is against the belt.
        let along_x =
            Pose::translation(0.0, -ahead, 0.0) * Pose::rotation(Vector3::y() * core::f64::consts::FRAC_PI_2);
        let barrier = LightBarrier::new(0.003, self.seed.wrapping_add(4 + 10 * arm as u64));
        FingerBarrier::new(AtTool::new(self.scene.clone(), hand), along_x, barrier, step)
    }
}

/// The frame of something beside the belt that looks across it, along x of W: `from` \[m\] off the middle of the belt.
fn across(s: f64, from: f64, over: f64) -> Pose {
    let look = UnitQuaternion::from_axis_angle(&Vector3::y_axis(), core::f64::consts::FRAC_PI_2);
    Pose::from_parts(Translation3::new(BELT[0] - from, BELT[1] + s, over), look)
}
