//! The robots' programs: what the arm and its hand do in each task.

use mrroc::prelude::*;
use mrroc_generators::combinators::Arbitrate;
use mrroc_generators::conditions::ConditionExt as _;
use mrroc_generators::generators::{JointMove, StraightLine};
use mrroc_robots::{Irp6, One, TwoFingers};
use mrroc_sensors::virtual_sensors::{Across, Between, Gate};

use crate::generators::{Chase, Close, Follow, Grasp, Part, Pursuit, Rise, Senses, Wait};
use crate::orders::Task;
use crate::places::{FINGERS, HIGH, HOME, LATEST, LIMIT, OPEN, OVER_TRAY, limits, over_tray, tool};

/// A part is known that can still be followed: the range finder has told of the same one as the gate.
fn known(v: &Reading<Senses>) -> bool {
    let (Some(gate), Some(range)) = (v.0.reading(), v.1.reading()) else { return false };
    gate.parts > 0 && range.parts > 0 && gate.place(0.0) < LATEST && Part::is_one(&gate, &range)
}

/// Something is between the fingers.
fn covered(v: &Reading<Senses>) -> bool {
    v.2.reading().is_some_and(|fingers| fingers.covered)
}

/// The arm: something between the fingers, close; a part is known, follow it; else wait. Then to its tray.
///
/// # Errors
/// The first fault of the cell.
pub fn arm(ecp: &mut Ecp<Irp6>, chase: &Chase) -> Result<(), Fault> {
    let (mut gate, mut range) = (ecp.sensor::<Gate>("gate")?, ecp.sensor::<Across>("range")?);
    let mut fingers = ecp.sensor::<Between>("fingers")?;
    let line = |pose| StraightLine::to(pose, limits());
    ecp.serve_all(|ecp, task| match task {
        Task::Pick => loop {
            chase.tool.set(Pursuit::at_rest(&ecp.image().demanded().pose));
            let close = || Close::new(chase.clone());
            let follow = || Follow::new(chase.clone());
            let rest = || Arbitrate::in_motion(follow, known, |_| false, || Wait(chase.clone()));
            let acquire = Arbitrate::in_motion(close, covered, |_| false, rest);
            ecp.blend_robot((&mut gate, &mut range, &mut fingers), acquire)?;
            ecp.move_robot((&mut fingers,), Rise::new(chase.clone()))?;
            let is_there = fingers.reading().is_some_and(|fingers| fingers.covered);
            if chase.part.get().is_some() && is_there {
                return Ok(());
            }
            chase.part.set(None);
        },
        Task::Carry { short, long } => {
            let is_long = chase.part.take().is_some_and(|part| part.length >= LIMIT);
            let tray = if is_long { long } else { short } as usize;
            ecp.move_robot((), line(over_tray(tray, HIGH)))?;
            ecp.move_robot((), line(over_tray(tray, OVER_TRAY))).map(drop)
        }
        Task::Return => ecp.move_robot((), line(tool(HOME, 0.0, HIGH))).map(drop),
        Task::Release => Ok(()),
    })
}

/// There is something between the fingers.
#[condition(ecp)]
fn there(v: &Reading<(Between,)>) -> bool {
    v.0.reading().is_some_and(|fingers| fingers.covered)
}

/// The hand: closes when something has been between its fingers for a while, and opens again when it no longer is; or when it is told to.
///
/// # Errors
/// The first fault of the cell.
pub fn hand(ecp: &mut Ecp<TwoFingers>) -> Result<(), Fault> {
    let mut fingers = ecp.sensor::<Between>("fingers")?;
    let open = || JointMove::to(One::new(OPEN), One::new(FINGERS[0]), One::new(FINGERS[1]));
    ecp.serve_all(|ecp, task| match task {
        Task::Pick => loop {
            ecp.wait_until((&mut fingers,), there {}.held_for(Close::WAITING))?;
            if !ecp.move_robot((&mut fingers,), Grasp::default())?.is_lost() {
                return Ok(());
            }
        },
        Task::Release => ecp.move_robot((), open()).map(drop),
        Task::Carry { .. } | Task::Return => Ok(()),
    })
}
