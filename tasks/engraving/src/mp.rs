//! The MP's program: three phases, one after the other. The arm does each on its own (loose cooperation).

use mrroc::prelude::*;
use mrroc_robots::Irp6;

/// What the MP orders: a constant from a finite set.
#[derive(Clone, Copy, Debug, PartialEq, Payload)]
pub enum Phase {
    /// Find the height of the plate.
    FindPlate,
    /// Engrave the drawing.
    Engrave,
    /// Go where the arm is out of the way.
    Park,
}

/// Orders one phase until the arm has finished it.
pub struct Ask(pub Phase);

#[generator(mp)]
fn ask(c: &mut Ask) -> Always<(Irp6,), Phase> {
    Always((c.0,))
}

/// The coordinating program.
///
/// # Errors
/// The first fault of the cell.
pub fn coordinate(mp: &mut Mp) -> Result<(), Fault> {
    let mut irp6 = mp.robot::<Irp6>("irp6")?;
    for phase in [Phase::FindPlate, Phase::Engrave, Phase::Park] {
        mp.move_robots((&mut irp6,), (), Ask(phase))?;
    }
    Ok(())
}
