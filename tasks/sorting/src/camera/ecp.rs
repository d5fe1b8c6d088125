//! The robots' programs: what the arm and its hand do in each task.

use core::cell::RefCell;
use core::f64::consts::FRAC_PI_2;

use mrroc::prelude::*;
use mrroc_generators::conditions::{ConditionExt as _, any, elapsed};
use mrroc_generators::generators::{JointMove, StraightLine};
use mrroc_robots::{Irp6, One, TwoFingers};
use mrroc_sensors::virtual_sensors::{Between, Encoder};

use super::acquire::{Acquire, at};
use super::carry::{OPENING, is_low, lines, lowered, raised};
use super::layout::{Station, limits};
use super::orders::Task;
use crate::generators::{Close, Grasp};
use crate::places::{FINGERS, HIGH, HOME, OPEN};
use crate::reach::Reach;

/// The arm at its station: with the part, by the belt's encoder, until the hand has it; then over its bin. With a part that it cannot bring
/// there within its reach it stays over the belt, until it is told to put that back; the part's number is noted in `stranded`.
///
/// # Errors
/// The first fault of the cell.
pub fn arm(
    ecp: &mut Ecp<Irp6>,
    station: &Station,
    reach: &Reach,
    stranded: &RefCell<Vec<u32>>,
) -> Result<(), Fault> {
    let (mut encoder, mut fingers) =
        (ecp.sensor::<Encoder>(station.encoder)?, ecp.sensor::<Between>(station.fingers)?);
    let line = |pose| StraightLine::to(pose, limits());
    ecp.serve_all(|ecp, task| match task {
        Task::Pick { part, place, bin } => {
            let yaw = ecp.move_robot((&mut encoder, &mut fingers), Acquire::new(place, station.along))?.yaw();
            if !fingers.reading().is_some_and(|fingers| fingers.covered) {
                return Ok(());
            }
            let now = *ecp.image().demanded();
            let Some(lines) = lines(reach, &now, station, bin as usize, yaw) else {
                stranded.borrow_mut().push(part);
                return Ok(());
            };
            lines.into_iter().try_for_each(|pose| ecp.move_robot((), line(pose)).map(drop))
        }
        Task::PutBack => ecp.move_robot((), line(lowered(&ecp.image().demanded().pose))).map(drop),
        Task::Return => ecp.move_robot((), line(at(HOME + station.along, 0.0, HIGH, FRAC_PI_2))).map(drop),
        Task::Release if is_low(&ecp.image().demanded().pose) => {
            ecp.wait_until((), elapsed(OPENING))?;
            ecp.move_robot((), line(raised(&ecp.image().demanded().pose))).map(drop)
        }
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
        Task::PutBack | Task::Return => Ok(()),
    })
}
