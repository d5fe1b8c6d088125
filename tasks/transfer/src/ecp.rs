//! The robots' programs: what an arm and what a hand does in each phase.

use core::marker::PhantomData;

use mrroc::prelude::*;
use mrroc_generators::cooperation::Displacement;
use mrroc_generators::generators::JointMove;
use mrroc_robots::{Gripper, One, Polycrank, Rnt};

use crate::generators::{Approach, Transmit};
use crate::orders::Phase;
use crate::places::{CLOSED, End, OPEN, back, bar, grasp, legs, limits};

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
        ecp.move_robot((), Approach::to(X_WE * back(), limits()))?;
        ecp.move_robot((), Approach::to(X_WE, limits())).map(drop)
    })?;
    for _ in legs() {
        ecp.serve(|ecp, _: Displacement| ecp.move_robot((), Transmit(PhantomData)).map(drop))?;
    }
    ecp.serve(|ecp, phase: Phase| {
        let X_EsE = phase.choose([(Phase::Withdraw, back())])?;
        ecp.move_robot((), Approach::by(X_EsE, limits())).map(drop)
    })
}

/// A hand: closes and opens.
fn hand(ecp: &mut Ecp<Gripper>) -> Result<(), Fault> {
    ecp.serve_all(|ecp, phase: Phase| {
        let opening = phase.choose([(Phase::Close, CLOSED), (Phase::Open, OPEN)])?;
        ecp.move_robot((), JointMove::to(One::new(opening), One::new(0.008), One::new(0.018))).map(drop)
    })
}
