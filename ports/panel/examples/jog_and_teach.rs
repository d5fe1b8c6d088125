//! Two arms that a person jogs and teaches at the panel: `cargo run --release -p mrroc-examples --example jog_and_teach --features
//! panel -- --cell ports/panel/examples/cell.toml --processes --panel --reduced`.
//!
//! The left arm goes home, lets itself be jogged until that is done, goes through what it was taught, and begins anew. The right
//! one is jogged all the time.

use std::path::{Path, PathBuf};

use mrroc::prelude::*;
use mrroc_generators::generators::{JointMove, PanelJog, Replay};
use mrroc_generators::line::ToolLimits;
use mrroc_generators::profile::ProfileLimits;
use mrroc_generators::teach::Taught;
use mrroc_robots::{Irp6, Six, simulated};

const HOME: Six = Six::new(0.0, -1.57, 0.16, -0.16, 4.71, 0.0);

fn main() -> std::process::ExitCode {
    mrroc::launch(cell, mrroc_pictures::Film::new())
}

fn cell(file: &CellFile) -> Result<Cell, CellError> {
    let poses: PathBuf = file.poses("left");
    let cell = file.cell(&simulated())?;
    Ok(cell.ecp::<Irp6>("left", move |ecp| jog_and_replay(ecp, &poses)).ecp::<Irp6>("right", jog))
}

// ANCHOR: jog
/// Three lines let a person jog an arm, until he says that it is done.
fn jog(ecp: &mut Ecp<Irp6>) -> Result<(), Fault> {
    let panel = ecp.jog_panel();
    ecp.move_robot((), PanelJog::by(panel))?;
    Ok(())
}
// ANCHOR_END: jog

fn jog_and_replay(ecp: &mut Ecp<Irp6>, poses: &Path) -> Result<(), Fault> {
    let tool = ProfileLimits { velocity: 0.2, acceleration: 0.5 };
    let tool = ToolLimits { translation: tool, rotation: tool };
    loop {
        ecp.move_robot((), JointMove::to(HOME, Six::repeat(0.1), Six::repeat(0.4)))?;
        jog(ecp)?;
        if poses.exists() {
            // ANCHOR: replay
            // What the page has taught meanwhile, in the order of the file; `select` takes some of them, by their names.
            let taught = Taught::read(poses)?;
            ecp.move_robot((), Replay::of(taught, Six::repeat(0.2), Six::repeat(0.8), tool))?;
            // ANCHOR_END: replay
        }
    }
}
