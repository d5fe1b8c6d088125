//! Two arms whose program takes trajectories of others, shown to others at the port `offered`.

use mrroc::prelude::*;
use mrroc_external::{Goals, Subscribers, TrajectoryGoals};
use mrroc_robots::{Irp6, simulated};

/// Makes the cell of `goals.toml`.
///
/// # Errors
/// What is wrong in the file.
pub fn cell(file: &CellFile) -> Result<Cell, CellError> {
    let goals = Goals::in_cell(file, "goals")?;
    Ok(file.cell(&simulated())?.sensor(goals).program(follow).shown_to(Subscribers::at("offered")))
}

// ANCHOR: follow
fn follow(mp: &mut Mp) -> Result<(), Fault> {
    let (mut left, mut right) = (mp.robot::<Irp6>("left")?, mp.robot::<Irp6>("right")?);
    let mut goals = TrajectoryGoals::new(mp, "goals", &["left", "right"])?;
    let arms = Each::of((goals.motion::<Irp6>("left")?, goals.motion::<Irp6>("right")?));
    mp.start_robots((&mut left, &mut right), arms)?;
    loop {
        goals.next(mp)?;
    }
}
// ANCHOR_END: follow
