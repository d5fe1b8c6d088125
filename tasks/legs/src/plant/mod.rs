//! What the simulated machine does in: the ground, the trunk on its legs, their drives, and sensors.

mod drives;
pub mod foot;
mod sensors;
pub mod trunk;
mod world;

use std::cell::RefCell;
use std::rc::Rc;

use mrroc::cell_file::Kinds;
use mrroc::prelude::*;
use mrroc::random::Random;
use mrroc_robots::Simulated;
use nalgebra::Vector3;

pub use drives::{Standing, standing};
pub use sensors::{FootForces, ForceCells, Forces, Inclinometer, Lean, Level};
pub use world::{PERIOD, SUBSTEPS, World};

use crate::ground::Ground;
use crate::leg::{GRAVITY, Leg};
use crate::places::{NAMES, hip, start};

/// The world of a cell.
#[derive(Clone, Debug)]
pub struct Plant(Rc<RefCell<World>>);

/// What is left to chance.
#[derive(Clone, Debug, PartialEq)]
#[allow(non_snake_case)]
pub struct Drawn {
    /// The ground as programs are told of it.
    pub told: Ground,
    /// As it is: edges off by up to 5 mm, treads by up to 4 mm.
    pub ground: Ground,
    /// Friction between feet and ground, 0.5 to 0.9.
    pub friction: f64,
    /// Where the trunk begins: up to 15 mm and 1° off.
    pub X_WT: Pose,
}

impl Drawn {
    /// By this seed, on steps of 2 cm for this length \[m\].
    #[must_use]
    pub fn by(seed: u64, length: f64) -> Self {
        let mut chance = Random::seeded(seed ^ 0x6c65_6773);
        let told = Ground::random(0.55, length, 0.02, &mut chance);
        let ground = told.clone().disturbed(0.005, 0.004, &mut chance);
        let friction = 0.5 + 0.4 * chance.unit();
        let at = Pose::translation(chance.within(0.015), chance.within(0.015), 0.0)
            * Pose::rotation(Vector3::z() * chance.within(1.0_f64.to_radians()));
        Self { told, ground, friction, X_WT: at }
    }

    /// Level ground that is as it is told to be, from where the trunk is believed to be.
    #[must_use]
    pub fn level(friction: f64) -> Self {
        let ground = Ground::level();
        Self { told: ground.clone(), ground, friction, X_WT: Pose::identity() }
    }
}

impl Plant {
    /// A machine on its feet at the start.
    #[must_use]
    pub fn new(drawn: &Drawn) -> Self {
        let legs: [Leg; 4] = core::array::from_fn(|i| Leg::at(hip(i)));
        let q = start();
        // The feet are in the ground by what a quarter of the weight presses them in.
        let mass = trunk::Sums::of(&legs, &q, &Default::default()).M;
        let sunk = 0.25 * mass * GRAVITY / foot::STIFFNESS;
        let up = foot::RADIUS - sunk - legs[0].foot(&q[0]).z;
        let pose = Pose::translation(0.0, 0.0, up) * drawn.X_WT;
        Self(Rc::new(RefCell::new(World::new(legs, drawn.ground.clone(), drawn.friction, pose, q))))
    }

    /// Trunk, legs and ground.
    #[must_use]
    pub fn world(&self) -> Rc<RefCell<World>> {
        Rc::clone(&self.0)
    }

    /// The kinds of `cell.toml`, with drives in this world.
    #[must_use]
    pub fn kinds(&self) -> Kinds {
        let world = self.world();
        Kinds::new().with("leg", move |entry| {
            let robot = Leg::at(entry.base());
            let Some(leg) = NAMES.iter().position(|name| *name == entry.name()) else {
                let what = format!("`{}` is none of the machine's legs", entry.name());
                return Err(entry.refuse_start(what, format!("call them {}", NAMES.join(", "))));
            };
            let drives = Simulated::new(robot.clone(), &entry.start(&robot)?);
            Ok(RobotSetup::new(entry.name(), robot, standing(drives, leg, Rc::clone(&world))))
        })
    }
}
