//! What a program of the diagnostics has at hand. None of them runs.

use mrroc::generator::{RobotHandle, SensorHandle};
use mrroc::prelude::*;

use crate::cell::{Camera, Polycrank, Rnt, WristForce};

/// The coordinator.
pub fn mp() -> Mp<'static> {
    unimplemented!("stand-in")
}

/// The controller of the Rnt.
pub fn ecp() -> Ecp<'static, Rnt> {
    unimplemented!("stand-in")
}

/// A handle.
pub fn rnt() -> RobotHandle<Rnt> {
    unimplemented!("stand-in")
}

/// A handle.
pub fn polycrank() -> RobotHandle<Polycrank> {
    unimplemented!("stand-in")
}

/// A handle.
pub fn force() -> SensorHandle<WristForce> {
    unimplemented!("stand-in")
}

/// A handle.
pub fn camera() -> SensorHandle<Camera> {
    unimplemented!("stand-in")
}
