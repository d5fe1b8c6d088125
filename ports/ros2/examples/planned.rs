//! A UR5e whose program takes plans of MoveIt, shown to others at the port `plans`.

use mrroc::prelude::*;
use mrroc_external::{Goals, Subscribers, TrajectoryGoals};
use mrroc_robots::{Serial, simulated};

type Arm = Serial<6>;

/// Makes the cell of `plans.toml`.
///
/// # Errors
/// What is wrong in the file.
pub fn cell(file: &CellFile) -> Result<Cell, CellError> {
    let goals = Goals::in_cell(file, "goals")?;
    Ok(file.cell(&simulated())?.sensor(goals).program(coordinate).shown_to(Subscribers::at("plans")))
}

// ANCHOR: coordinate
/// The arm follows one plan after the other.
pub fn coordinate(mp: &mut Mp) -> Result<(), Fault> {
    let mut arm = mp.robot::<Arm>("arm")?; // named as in cell.toml
    let mut goals = TrajectoryGoals::new(mp, "goals", &["arm"])?;
    let motion = goals.motion::<Arm>("arm")?;
    mp.start_robot(&mut arm, motion)?;
    loop {
        goals.next(mp)?;
    }
}
// ANCHOR_END: coordinate
