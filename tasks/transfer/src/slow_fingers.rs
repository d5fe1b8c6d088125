//! The drive of a hand: slower than those of the arms, 250 Hz beside 500 Hz.

use core::time::Duration;

use mrroc::{DriveFault, Driver, Measured};
use mrroc_robots::grasp::Fingers;
use mrroc_robots::{Gripper, One};

/// [`Fingers`] that take a demand every 4 ms and go there evenly.
#[derive(Debug)]
pub struct SlowFingers {
    fingers: Fingers,
    demanded: One,
}

impl SlowFingers {
    /// Servo periods of the fingers in one of the hand.
    const PARTS: u32 = 2;

    /// The slow drive of these fingers.
    #[must_use]
    pub fn new(fingers: Fingers) -> Self {
        SlowFingers { demanded: fingers.measured().position, fingers }
    }
}

impl Driver<Gripper> for SlowFingers {
    fn period(&self) -> Duration {
        self.fingers.period() * Self::PARTS
    }

    fn measured(&self) -> Measured<One> {
        self.fingers.measured()
    }

    fn tick(&mut self, demanded: &One) -> Result<Measured<One>, DriveFault> {
        let from = core::mem::replace(&mut self.demanded, *demanded);
        let mut measured = self.fingers.measured();
        for part in 1..=Self::PARTS {
            let share = f64::from(part) / f64::from(Self::PARTS);
            measured = self.fingers.tick(&(from + (demanded - from) * share))?;
        }
        Ok(measured)
    }
}
