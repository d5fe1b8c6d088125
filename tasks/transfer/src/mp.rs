//! The coordinator's program: the task as a sequence of instructions.

use mrroc::prelude::*;
use mrroc_robots::{Gripper, Polycrank, Rnt};

use crate::generators::{Carry, Trigger};
use crate::orders::Phase;
use crate::paths::soft;
use crate::places::{bar, legs, limits};

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
        let carry = Carry::along(X_WB, soft(X_BsB, limits())?);
        mp.move_robots((&mut rnt, &mut polycrank), (), carry)?;
        X_WB *= X_BsB;
    }
    mp.move_robots([&mut hands.0, &mut hands.1], (), Trigger::to(Phase::Open))?;
    mp.move_robots((&mut rnt, &mut polycrank), (), Trigger::to(Phase::Withdraw))?;
    Ok(())
}
