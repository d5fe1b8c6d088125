//! A rate gyro: how far the base has turned since it was asked last, with the errors of one.
//!
//! ```text
//! r = (1 + k) d(heading) + bias dt + noise,    bias walks;    a rate beyond its range is its range
//! ```
//!
//! It adds its samples up by itself, as chips with a queue do: no turn is missed between two readings.

use core::f64::consts::TAU;

use mrroc::random::Random;

use crate::simulation::Floor;

/// How a gyro may be broken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GyroFault {
    /// It says the same as if the base never turned.
    Dead,
    /// It does not answer.
    Silent,
}

/// What a gyro says of the time since it was asked last.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Turned {
    /// How far it turned \[rad\], bias and all.
    pub angle: f64,
    /// How long that took \[s\].
    pub time: f64,
}

/// A simulated gyro on a base.
#[derive(Debug)]
pub struct Gyro {
    floor: Floor,
    chance: Random,
    /// What it reads at rest [rad/s].
    bias: f64,
    scale: f64,
    heading: f64,
    time: f64,
    fault: Option<GyroFault>,
}

impl Gyro {
    /// Largest rate at rest that it may have been delivered with [rad/s]: 2 degrees a second.
    pub const BIAS: f64 = 0.035;
    /// Its largest error of scale, after it has been calibrated.
    pub const SCALE: f64 = 0.002;
    /// Noise of the angle after a second \[rad\]: 0.3 degrees in the root of an hour.
    pub const NOISE: f64 = 8.7e-5;
    /// How far the bias walks in a second [rad/s].
    pub const WALK: f64 = 2e-5;
    /// The largest rate that it can say [rad/s]: 2000 degrees a second.
    pub const RANGE: f64 = 34.9;

    /// On the base of this floor, with errors by chance.
    #[must_use]
    pub fn new(floor: Floor, seed: u64) -> Self {
        let mut chance = Random::seeded(seed ^ 0x6779_726f);
        let (bias, scale) = (chance.within(Self::BIAS), chance.within(Self::SCALE));
        let (heading, time) = (floor.motion().pose.heading, floor.time());
        Self { floor, chance, bias, scale, heading, time, fault: None }
    }

    /// Breaks it.
    pub fn fail(&mut self, fault: GyroFault) {
        self.fault = Some(fault);
    }

    /// What it reads at rest now [rad/s], for checks.
    #[must_use]
    pub const fn bias(&self) -> f64 {
        self.bias
    }

    /// What it says; `None` of one that does not answer.
    pub fn ask(&mut self) -> Option<Turned> {
        let (heading, now) = (self.floor.motion().pose.heading, self.floor.time());
        let time = now - core::mem::replace(&mut self.time, now);
        let turned = heading - core::mem::replace(&mut self.heading, heading);
        let root = time.sqrt();
        self.bias += Self::WALK * root * normal(&mut self.chance);
        let noise = Self::NOISE * root * normal(&mut self.chance);
        let most = Self::RANGE * time;
        let angle = ((1.0 + self.scale) * turned + self.bias * time + noise).clamp(-most, most);
        match self.fault {
            None => Some(Turned { angle, time }),
            Some(GyroFault::Dead) => Some(Turned { angle: self.bias * time + noise, time }),
            Some(GyroFault::Silent) => None,
        }
    }
}

/// A number of the standard normal distribution (Box and Muller).
pub(crate) fn normal(chance: &mut Random) -> f64 {
    let (a, b) = (1.0 - chance.unit(), chance.unit());
    (-2.0 * a.ln()).sqrt() * (TAU * b).cos()
}
