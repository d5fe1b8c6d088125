//! The coordinator of a reactive arm only starts it: it has the maze found by three touches, and says where the exit is.

use mrroc::prelude::*;
use mrroc_robots::Irp6;
use nalgebra::Point3;

use crate::found::by_three_touches;
use crate::mp::{MazeSettings, carried_out};
use crate::orders::Task;
use crate::plant::TouchProbe;

/// Has the maze found, and the arm leave it.
///
/// # Errors
/// The first fault of the cell.
pub fn coordinate(mp: &mut Mp, told: &MazeSettings) -> Result<(), Fault> {
    let (mut arm, mut probe) = (mp.robot::<Irp6>("arm")?, mp.sensor::<TouchProbe>("probe")?);
    let mut touches = 0;
    let mut have = |task| carried_out(mp, (&mut arm, &mut probe), &mut touches, task);
    let (maze, _) = by_three_touches(&mut have, told)?;
    let (middle, half) =
        ((told.goal.lower + told.goal.upper) * 0.5, (told.goal.upper - told.goal.lower) * 0.5);
    let exit = maze * Point3::new(middle.x, middle.y, 0.0);
    have(Task::Leave { x: exit.x, y: exit.y, near: half.min() }).map(drop)
}
