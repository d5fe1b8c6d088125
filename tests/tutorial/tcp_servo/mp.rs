//! The coordinator: the table turns to and fro.

use mrroc::prelude::*;
use mrroc_generators::generators::JointMove;
use mrroc_robots::One;

use crate::arm::Arm;

/// Three times by a radian to either side.
pub fn coordinate(mp: &mut Mp) -> Result<(), Fault> {
    let mut table = mp.robot::<Arm>("table")?;
    for goal in [1.0, -1.0, 1.0, -1.0, 1.0, 0.0] {
        mp.move_robot(&mut table, (), JointMove::to(One::new(goal), One::new(0.5), One::new(1.0)))?;
    }
    Ok(())
}
