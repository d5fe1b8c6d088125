//! Sensors of robots: the kind of a force and torque sensor at a wrist, and what a robot tells by itself.
//!
//! The simulated sensor of the same kind is [`SimulatedWrist`](crate::grasp::SimulatedWrist).

mod robot_wrench;

pub use robot_wrench::RobotWrench;

use mrroc::pose::Wrench;
use mrroc::prelude::*;

/// The kind of sensor: a force and torque sensor at an arm's wrist. Its reading is `F_E`, the wrench of the surroundings on
/// the tool, without the tool's weight: at the origin of the tool frame E and in its axes.
#[derive(Clone, Copy, Debug)]
pub struct WristForce;

impl Sensor for WristForce {
    const KIND: &'static str = "wrist force";
    type Reading = Wrench;
    type Configuration = WristOrder;
}

/// What is ordered of a wrist sensor.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Payload)]
pub enum WristOrder {
    /// A reading.
    #[default]
    Read,
    /// A measurement of its bias, during which nothing may touch the tool. Orders of consecutive steps are averaged.
    MeasureBias,
}

/// The bias of a wrist sensor: the mean of what it read while it was told to measure it.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Bias {
    /// To be subtracted.
    pub value: Wrench,
    averaged: f64,
}

impl Bias {
    /// One that is known.
    pub const fn known(value: Wrench) -> Self {
        Bias { value, averaged: 0.0 }
    }

    /// A reading is ordered, not a measurement.
    pub const fn read(&mut self) {
        self.averaged = 0.0;
    }

    /// Takes a measurement without any load: the mean of those in a row.
    pub fn measure(&mut self, unloaded: Wrench) {
        self.averaged += 1.0;
        let last = if self.averaged > 1.0 { self.value } else { unloaded };
        self.value = last + (unloaded - last) * self.averaged.recip();
    }
}
