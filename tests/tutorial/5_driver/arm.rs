//! The kind of robot, and what drives it.

use std::time::Duration;

use mrroc::cell::RobotSetup;
use mrroc::cell_file::Kinds;
use mrroc::robot::{DriveFault, Driver, Measured};
use mrroc_robots::Six;

pub use mrroc_robots::Irp6 as Arm;

/// Real drives where `cell.toml` says "irp6".
pub fn kinds() -> Kinds {
    mrroc_robots::simulated().with("irp6", |entry| {
        let arm = Arm::nominal().with_base(entry.base());
        let bus = Bus { counts: counts(&entry.start(&arm)?), connected: true };
        Ok(RobotSetup::new(entry.name(), arm, Drives { bus, velocity: Six::zeros() }))
    })
}

/// The servo period, and what a count of an encoder stands for [rad].
const PERIOD: Duration = Duration::from_millis(2);
const COUNT: f64 = 1e-5;

fn counts(joints: &Six) -> [i64; 6] {
    std::array::from_fn(|i| (joints[i] / COUNT).round() as i64)
}

/// FILL IN: the link to the hardware. Until then its drives go where they are told, to the nearest count.
pub struct Bus {
    pub counts: [i64; 6],
    pub connected: bool,
}

impl Bus {
    /// Sends what is demanded, receives what the encoders read; nothing if the drives do not answer.
    fn exchange(&mut self, demanded: [i64; 6]) -> Option<[i64; 6]> {
        self.counts = demanded;
        self.connected.then_some(self.counts)
    }
}

/// What the robot's EDP calls.
pub struct Drives {
    pub bus: Bus,
    pub velocity: Six,
}

impl Driver<Arm> for Drives {
    fn period(&self) -> Duration {
        PERIOD
    }

    /// Which hardware the drives are, if they are real.
    fn hardware(&self) -> Option<String> {
        None
    }

    /// What was read last; nothing moves.
    fn measured(&self) -> Result<Measured<Six>, DriveFault> {
        let position = Six::from_fn(|i, _| self.bus.counts[i] as f64 * COUNT);
        Ok(Measured { position, velocity: self.velocity })
    }

    /// One servo period. The demand is within all limits already.
    fn tick(&mut self, demanded: &Six) -> Result<Measured<Six>, DriveFault> {
        let before = self.measured()?.position;
        let answer = self.bus.exchange(counts(demanded));
        self.bus.counts = answer.ok_or(DriveFault::NoAnswer)?;
        self.velocity = (self.measured()?.position - before) / PERIOD.as_secs_f64();
        self.measured()
    }
}
