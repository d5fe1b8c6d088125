//! The robot: its task as a sequence of instructions.

use mrroc::prelude::*;
use mrroc_generators::line::ToolLimits;
use mrroc_generators::profile::ProfileLimits;

use crate::arm::Arm;
use crate::generators::MyLine;

/// Gives the robot its program.
pub fn programs(cell: Cell) -> Cell {
    cell.ecp("arm", arm)
}

fn arm(ecp: &mut Ecp<Arm>) -> Result<(), Fault> {
    let limits = ProfileLimits { velocity: 0.1, acceleration: 0.5 }; // m/s and rad/s, m/s² and rad/s²
    let limits = ToolLimits { translation: limits, rotation: limits };
    let up = Pose::translation(0.0, 0.0, -0.1); // the tool's z axis points down
    ecp.move_robot((), MyLine::by(up, limits))?;
    ecp.move_robot((), MyLine::by(up.inverse(), limits))?;
    Ok(())
}
