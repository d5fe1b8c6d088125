//! The robots' programs: what the arm and its hand do in each task.

use core::f64::consts::FRAC_PI_2;

use mrroc::prelude::*;
use mrroc_generators::conditions::{ConditionExt as _, any, elapsed};
use mrroc_generators::generators::{JointMove, StraightLine};
use mrroc_robots::{Irp6, One, TwoFingers};
use mrroc_sensors::virtual_sensors::{Between, Encoder};

use super::acquire::{Acquire, at};
use super::layout::{Station, bin, limits};
use super::orders::Task;
use crate::generators::{Close, Grasp};
use crate::places::{BELT, FINGERS, HIGH, HOME, OPEN, OVER_TRAY};

/// The arm at its station: with the part, by the belt's encoder, until the hand has it; then over its bin.
///
/// # Errors
/// The first fault of the cell.
pub fn arm(ecp: &mut Ecp<Irp6>, station: &Station) -> Result<(), Fault> {
    let (mut encoder, mut fingers) =
        (ecp.sensor::<Encoder>(station.encoder)?, ecp.sensor::<Between>(station.fingers)?);
    let line = |pose| StraightLine::to(pose, limits());
    ecp.serve_all(|ecp, task| match task {
        Task::Pick { place, bin: number, .. } => {
            let yaw = ecp.move_robot((&mut encoder, &mut fingers), Acquire::new(place, station.along))?.yaw();
            if !fingers.reading().is_some_and(|fingers| fingers.covered) {
                return Ok(());
            }
            let ([x, y], _) = bin(number as usize);
            let over = |height| at(y - BELT[1] + station.along, x - BELT[0], height, yaw);
            ecp.move_robot((), line(over(HIGH)))?;
            ecp.move_robot((), line(over(OVER_TRAY))).map(drop)
        }
        Task::Return => ecp.move_robot((), line(at(HOME + station.along, 0.0, HIGH, FRAC_PI_2))).map(drop),
        Task::Release => Ok(()),
    })
}

/// There is something between the fingers.
#[condition(ecp)]
fn there(v: &Reading<(Between,)>) -> bool {
    v.0.reading().is_some_and(|fingers| fingers.covered)
}

/// The hand: closes when something has been between its fingers for a while, unless nothing comes; opens when it is told to.
///
/// # Errors
/// The first fault of the cell.
pub fn hand(ecp: &mut Ecp<TwoFingers>, station: &Station) -> Result<(), Fault> {
    let mut fingers = ecp.sensor::<Between>(station.fingers)?;
    let open = || JointMove::to(One::new(OPEN), One::new(FINGERS[0]), One::new(FINGERS[1]));
    ecp.serve_all(|ecp, task| match task {
        Task::Pick { .. } => {
            ecp.wait_until(
                (&mut fingers,),
                any((there {}.held_for(Close::WAITING), elapsed(Acquire::TIMEOUT))),
            )?;
            ecp.move_robot((&mut fingers,), Grasp::default()).map(drop)
        }
        Task::Release => ecp.move_robot((), open()).map(drop),
        Task::Return => Ok(()),
    })
}
