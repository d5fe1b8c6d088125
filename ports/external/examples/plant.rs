//! Arms draw straight lines in a simulator that others wrote: `cargo run -p mrroc-examples --example plant -- --cell
//! ports/external/examples/plant.toml` while `mujoco_arms.py` runs, or with `--simulated` without it. `external left` prints the
//! Python module that this script imports.
//!
//! `--metres` behind a `--` says how long the lines are, 0.2 by default.

use mrroc::launch::own_number;
use mrroc::prelude::*;
use mrroc_external::plant;
use mrroc_generators::generators::{Delay, StraightLine};
use mrroc_generators::line::ToolLimits;
use mrroc_generators::profile::ProfileLimits;
use mrroc_robots::{Serial, simulated};

fn main() -> std::process::ExitCode {
    mrroc::launch(cell, mrroc_pictures::Film::new())
}

// ANCHOR: cell
fn cell(file: &CellFile) -> Result<Cell, CellError> {
    let cell = file.cell(&simulated().plants(plant))?;
    Ok(file.robots().iter().fold(cell, |cell, arm| cell.ecp::<Serial<6>>(arm.name(), draw)))
}
// ANCHOR_END: cell

/// Down and back along the axis of the tool, then down again, and stay there until the arm stands.
fn draw(ecp: &mut Ecp<Serial<6>>) -> Result<(), Fault> {
    let metres = own_number("metres", 0.2)?;
    let limits = ProfileLimits { velocity: 0.25, acceleration: 0.5 };
    let limits = ToolLimits { translation: limits, rotation: limits };
    let line = |z: f64| StraightLine::by(Pose::translation(0.0, 0.0, z), limits);
    ecp.move_robot((), line(metres))?;
    ecp.move_robot((), line(-metres))?;
    ecp.move_robot((), line(metres))?;
    ecp.move_robot((), Delay::lasting(0.3))?;
    Ok(())
}
