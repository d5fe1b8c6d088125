//! The task as it was begun: every motion is a generator of the library.

use mrroc::prelude::*;
use mrroc_generators::cooperation::{BodyFrame, Displacement, StraightBody};
use mrroc_generators::generators::{JointMove, RigidCarry, StraightLine, TransmitDisplacement};
use mrroc_robots::{Gripper, One, Polycrank, Rnt};

use crate::generators::Trigger;
use crate::orders::Phase;
use crate::places::{CLOSED, End, OPEN, back, bar, grasp, legs, limits};

/// The whole task.
///
/// # Errors
/// The first fault of the cell.
#[allow(non_snake_case)]
pub fn coordinate(mp: &mut Mp) -> Result<(), Fault> {
    let (mut rnt, mut polycrank) = (mp.robot::<Rnt>("rnt")?, mp.robot::<Polycrank>("polycrank")?);
    let mut hands = (mp.robot::<Gripper>("rnt-hand")?, mp.robot::<Gripper>("polycrank-hand")?);
    mp.move_robots((&mut rnt, &mut polycrank), (), Trigger::to(Phase::Approach))?;
    mp.move_robots([&mut hands.0, &mut hands.1], (), Trigger::to(Phase::Close))?;
    let mut X_WB = bar();
    for X_BsB in legs() {
        let path = StraightBody::by(X_BsB, limits());
        let carry = RigidCarry::along(BodyFrame::InWorld(X_WB), path).by_displacements();
        mp.move_robots((&mut rnt, &mut polycrank), (), carry)?;
        X_WB *= X_BsB;
    }
    mp.move_robots([&mut hands.0, &mut hands.1], (), Trigger::to(Phase::Open))?;
    mp.move_robots((&mut rnt, &mut polycrank), (), Trigger::to(Phase::Withdraw))?;
    Ok(())
}

/// Gives every robot its program.
#[must_use]
pub fn programs(cell: Cell) -> Cell {
    cell.ecp("rnt", |ecp: &mut Ecp<Rnt>| arm(ecp, End::Near))
        .ecp("polycrank", |ecp: &mut Ecp<Polycrank>| arm(ecp, End::Far))
        .ecp("rnt-hand", hand)
        .ecp("polycrank-hand", hand)
}

/// An arm: loose to its grasp, tight with the body, loose again.
#[allow(non_snake_case)]
fn arm<R: Robot>(ecp: &mut Ecp<R>, end: End) -> Result<(), Fault> {
    ecp.serve(|ecp, phase: Phase| {
        let X_WE = phase.choose([(Phase::Approach, bar() * grasp(end))])?;
        ecp.move_robot((), StraightLine::to(X_WE * back(), limits()))?;
        ecp.move_robot((), StraightLine::to(X_WE, limits())).map(drop)
    })?;
    for _ in legs() {
        ecp.serve(|ecp, _: Displacement| ecp.move_robot((), TransmitDisplacement::new()).map(drop))?;
    }
    ecp.serve(|ecp, phase: Phase| {
        let X_EsE = phase.choose([(Phase::Withdraw, back())])?;
        ecp.move_robot((), StraightLine::by(X_EsE, limits())).map(drop)
    })
}

/// A hand: closes and opens.
fn hand(ecp: &mut Ecp<Gripper>) -> Result<(), Fault> {
    ecp.serve_all(|ecp, phase: Phase| {
        let opening = phase.choose([(Phase::Close, CLOSED), (Phase::Open, OPEN)])?;
        ecp.move_robot((), JointMove::to(One::new(opening), One::new(0.008), One::new(0.018))).map(drop)
    })
}
