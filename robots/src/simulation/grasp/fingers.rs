//! A gripper that is a robot of its own, and whose fingers close on the world's body.

use core::time::Duration;

use mrroc::robot::{DriveFault, Driver, Measured, Regulators, SimulatedDrives};

use super::error::{WorldError, positive};
use super::grip::Hand;
use crate::models::{Gripper, One};
use crate::simulation::simulated::{Shaft, Simulated};

/// The drive of a [`Gripper`] on an arm's hand. Fingers that are demanded to close beyond the body's width stop at it and
/// hold it, if it is between them; a grasp without a frame of its own (`Grasp::at`) assumes that it is. Fingers that are
/// demanded to open let the body go.
#[derive(Debug)]
pub struct Fingers {
    drive: Simulated<Gripper, 1>,
    shaft: Shaft<1>,
    hand: Hand,
    width: f64,
}

impl Fingers {
    /// The fingers of `hand`; the body is `width` \[m\] wide between them.
    ///
    /// # Errors
    /// [`WorldError`] when the width is not above 0.
    pub fn new(drive: Simulated<Gripper, 1>, hand: Hand, width: f64) -> Result<Self, WorldError> {
        let width = positive("the body's width", width, "m")?;
        Ok(Self { shaft: drive.shaft(), drive, hand, width })
    }
}

impl Driver<Gripper> for Fingers {
    fn period(&self) -> Duration {
        self.drive.period()
    }

    fn measured(&self) -> Result<Measured<One>, DriveFault> {
        self.drive.measured()
    }

    fn tick(&mut self, demanded: &One) -> Result<Measured<One>, DriveFault> {
        let closing = demanded[0] < self.width;
        if !closing && self.hand.is_closed() {
            self.hand.open();
            self.drive.unblock(0);
        }
        // Where the grasp has a frame on the body and the body is elsewhere, the fingers close on nothing.
        let touching = closing && self.shaft.state().position[0] <= self.width;
        if touching && !self.hand.is_closed() && self.hand.close().is_ok() {
            self.drive.block(0);
        }
        self.drive.tick(demanded)
    }

    fn motor_currents(&self) -> Option<One> {
        self.drive.motor_currents()
    }

    fn simulation(&mut self) -> Option<&mut dyn SimulatedDrives<Gripper>> {
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

impl SimulatedDrives<Gripper> for Fingers {
    fn brake(&mut self) -> Measured<One> {
        self.drive.brake()
    }
}
