//! Two arms that go to and fro, shown to others at the port `arms`.

use mrroc::launch::own_number;
use mrroc::prelude::*;
use mrroc_external::Subscribers;
use mrroc_generators::generators::{JointMove, Tell};
use mrroc_robots::{Irp6, Six, simulated};

// ANCHOR: cell
/// Makes the cell of `cell.toml`.
///
/// # Errors
/// What is wrong in the file.
pub fn cell(file: &CellFile) -> Result<Cell, CellError> {
    Ok(file.cell(&simulated())?.program(to_and_fro).shown_to(Subscribers::at("arms")))
}
// ANCHOR_END: cell

fn to_and_fro(mp: &mut Mp) -> Result<(), Fault> {
    let turns = own_number("turns", 1000_u32)?;
    let (mut left, mut right) = (mp.robot::<Irp6>("left")?, mp.robot::<Irp6>("right")?);
    let to = |column: f64, arm: f64| {
        let mut q = Six::new(column, -1.57 + arm, 0.16 - 0.5 * arm, -0.16, 4.71, 0.8 * column);
        q[3] += 0.3 * arm;
        JointMove::<Irp6>::to(q, Six::repeat(0.4), Six::repeat(0.8))
    };
    let gripper = left.output::<bool>("gripper")?;
    for turn in 0..turns {
        mp.move_robot(&mut left, (), Tell::output(gripper, turn % 2 == 1))?;
        mp.move_robots((&mut left, &mut right), (), Each::of((to(0.5, 0.3), to(-0.3, 0.2))))?;
        mp.move_robots((&mut left, &mut right), (), Each::of((to(-0.4, -0.1), to(0.4, 0.3))))?;
    }
    Ok(())
}
