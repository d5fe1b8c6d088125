//! A gripper that is a robot of its own, and whose fingers touch whatever is between them.

use core::time::Duration;

use mrroc::robot::{DriveFault, Driver, Measured, Regulators, Robot, SimulatedDrives};

use super::error::WorldError;
use super::grip::Hand;
use super::pads::Pads;
use crate::models::{Driven, One};
use crate::simulation::simulated::{Shaft, Simulated};

/// The drive of a gripper of one joint, its opening, on an arm's hand. Its pads push a body that comes between them, and hold it when
/// both press; then the drive stands, as if blocked. Fingers that are demanded to open by more than [`Jaws::SLACK`] let it go.
#[derive(Debug)]
pub struct Jaws<R: Driven<1>> {
    drive: Simulated<R, 1>,
    shaft: Shaft<1>,
    hand: Hand,
    /// The opening at which they hold a body \[m\].
    holding: Option<f64>,
}

impl<R: Driven<1> + Robot<Joints = One>> Jaws<R> {
    /// A demanded opening that exceeds the one at which a body is held by more than this lets it go \[m\].
    pub const SLACK: f64 = 1e-3;

    /// The fingers of `hand`, with these pads.
    ///
    /// # Errors
    /// [`WorldError`] when a figure of the pads is out of range.
    pub fn new(drive: Simulated<R, 1>, hand: Hand, pads: Pads) -> Result<Self, WorldError> {
        let shaft = drive.shaft();
        hand.fit(pads, shaft.state().position[0])?;
        Ok(Self { shaft, drive, hand, holding: None })
    }

    /// Its hand in the world.
    #[must_use]
    pub fn hand(&self) -> Hand {
        self.hand.clone()
    }

    /// The drive moves, and the pads with it.
    fn in_world<T>(&mut self, period: impl FnOnce(&mut Simulated<R, 1>) -> T) -> T {
        let before = self.shaft.state().position[0];
        if self.hand.is_closed() && self.holding.is_none() {
            self.holding = Some(before);
            self.drive.block(0);
        }
        let outcome = period(&mut self.drive);
        let duration = self.drive.period().as_secs_f64();
        let rate = (self.shaft.state().position[0] - before) / duration;
        self.hand.set_opening(before, rate, duration);
        outcome
    }
}

impl<R: Driven<1> + Robot<Joints = One>> Driver<R> for Jaws<R> {
    fn period(&self) -> Duration {
        self.drive.period()
    }

    fn measured(&self) -> Result<Measured<One>, DriveFault> {
        self.drive.measured()
    }

    fn tick(&mut self, demanded: &One) -> Result<Measured<One>, DriveFault> {
        if self.holding.is_some_and(|opening| demanded[0] > opening + Self::SLACK) {
            self.holding = None;
            self.hand.open();
            self.drive.unblock(0);
        }
        self.hand.set_closing(demanded[0] < self.shaft.state().position[0]);
        self.in_world(|drive| drive.tick(demanded))
    }

    fn motor_currents(&self) -> Option<One> {
        self.drive.motor_currents()
    }

    fn simulation(&mut self) -> Option<&mut dyn SimulatedDrives<R>> {
        Some(self)
    }

    fn has_brakes(&self) -> bool {
        self.drive.has_brakes()
    }

    fn switch_off(&mut self) {
        self.drive.switch_off();
    }

    fn switch_on(&mut self) -> Result<(), DriveFault> {
        self.drive.switch_on()
    }

    fn has_regulator(&self, joint: usize, set: u8) -> bool {
        self.drive.has_regulator(joint, set)
    }

    fn choose_regulators(&mut self, sets: &Regulators) {
        self.drive.choose_regulators(sets);
    }
}

impl<R: Driven<1> + Robot<Joints = One>> SimulatedDrives<R> for Jaws<R> {
    fn brake(&mut self) -> Measured<One> {
        self.in_world(Simulated::brake)
    }
}
