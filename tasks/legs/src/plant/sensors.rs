//! Virtual sensors of the machine: what bears on the feet, and how the trunk stands to the level.
//!
//! ```text
//! feet    r: a force cell in each shank      f_v: forces along the trunk's z, less what they read in the air      v: four forces
//! level   r: an inclinometer                 f_v: a mean over 20 ms                                               v: roll and pitch
//! ```

use std::cell::RefCell;
use std::rc::Rc;

use mrroc::prelude::*;
use mrroc::random::Random;
use nalgebra::Vector3;

use super::world::World;

/// The kind of sensor: a force cell in each leg.
#[derive(Clone, Copy, Debug)]
pub struct FootForces;

impl Sensor for FootForces {
    const KIND: &'static str = "foot forces";
    type Reading = Forces;
    type Configuration = ();
}

/// What bears on the feet.
#[derive(Clone, Copy, Debug, Default, PartialEq, Payload)]
pub struct Forces {
    /// The force of the ground on each foot along the trunk's z \[N\]: left and right in front, left and right behind.
    pub up: [f64; 4],
}

/// The kind of sensor: an inclinometer in the trunk.
#[derive(Clone, Copy, Debug)]
pub struct Level;

impl Sensor for Level {
    const KIND: &'static str = "inclinometer";
    type Reading = Lean;
    type Configuration = ();
}

/// How the trunk stands to the level.
#[derive(Clone, Copy, Debug, Default, PartialEq, Payload)]
pub struct Lean {
    /// Turn about x, then about the turned y, that take the level to the trunk \[rad\].
    pub roll: f64,
    /// See `roll`.
    pub pitch: f64,
}

/// Makes readings of the force cells: with a noise of 1 N and an error of zero of 2 N at most (assumed).
#[derive(Debug)]
pub struct ForceCells {
    world: Rc<RefCell<World>>,
    zero: [f64; 4],
    chance: Random,
}

impl ForceCells {
    /// Of this machine.
    #[must_use]
    pub fn new(world: Rc<RefCell<World>>, seed: u64) -> Self {
        let mut chance = Random::seeded(seed ^ 0x666f_7263);
        Self { world, zero: core::array::from_fn(|_| chance.within(2.0)), chance }
    }
}

impl VirtualSensor for ForceCells {
    type Kind = FootForces;

    fn aggregate(&mut self, _order: &ReadingOrder<()>) -> Result<Forces, Fault> {
        let loads = *self.world.borrow().loads();
        Ok(Forces { up: core::array::from_fn(|i| loads[i].z + self.zero[i] + self.chance.within(1.0)) })
    }

    fn is_simulated(&self) -> bool {
        true
    }
}

/// Makes readings of the inclinometer: with a noise of 0.03° and an error of zero of 0.1° at most (assumed).
#[derive(Debug)]
pub struct Inclinometer {
    world: Rc<RefCell<World>>,
    zero: [f64; 2],
    chance: Random,
    mean: Option<[f64; 2]>,
}

impl Inclinometer {
    /// Share of a reading in the mean, at steps of 4 ms: time constant 20 ms.
    const SHARE: f64 = 0.2;

    /// Of this machine.
    #[must_use]
    pub fn new(world: Rc<RefCell<World>>, seed: u64) -> Self {
        let mut chance = Random::seeded(seed ^ 0x6c65_7665);
        let zero = core::array::from_fn(|_| chance.within(0.1_f64.to_radians()));
        Self { world, zero, chance, mean: None }
    }
}

impl VirtualSensor for Inclinometer {
    type Kind = Level;

    #[allow(non_snake_case)]
    fn aggregate(&mut self, _order: &ReadingOrder<()>) -> Result<Lean, Fault> {
        let X_WT = self.world.borrow().standing().X_WT;
        // Up, in the trunk: (-sin pitch, sin roll cos pitch, cos roll cos pitch).
        let up = X_WT.rotation.inverse() * Vector3::z();
        let true_lean = [up.y.atan2(up.z), -up.x.asin()];
        let noise = 0.03_f64.to_radians();
        let now: [f64; 2] = core::array::from_fn(|i| true_lean[i] + self.zero[i] + self.chance.within(noise));
        let before = self.mean.unwrap_or(now);
        let mean: [f64; 2] = core::array::from_fn(|i| before[i] + Self::SHARE * (now[i] - before[i]));
        self.mean = Some(mean);
        Ok(Lean { roll: mean[0], pitch: mean[1] })
    }

    fn is_simulated(&self) -> bool {
        true
    }
}
