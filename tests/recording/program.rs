//! The cell of the tests of recordings as a task program. `MRROC_TEST_CHANGE` names a path time \[s\] from which its swing is
//! another one.

#[allow(dead_code, reason = "the tests use the rest")]
mod cell;

use std::io;
use std::path::Path;
use std::process::ExitCode;

use mrroc::{Cell, CellError, CellFile, RunPicture};

use cell::{Change, Counting, programmed};

fn main() -> ExitCode {
    mrroc::launch(assemble, Nothing)
}

fn assemble(file: &CellFile) -> Result<Cell, CellError> {
    let change = std::env::var("MRROC_TEST_CHANGE").ok().and_then(|text| text.parse().ok());
    let cell = file
        .cell(&mrroc_robots::simulated())?
        .sensor(file.sensor("count", Counting::default())?)
        .sensor(file.sensor("slow", Counting::default())?)
        .sensor(file.sensor("free", Counting::default())?);
    Ok(programmed(cell, change.map_or(Change::Nothing, Change::Swing)))
}

/// Draws nothing.
struct Nothing;

impl RunPicture for Nothing {
    fn watch(&mut self, cell: Cell) -> Cell {
        cell
    }

    fn save(&mut self, _: &Path) -> io::Result<()> {
        Ok(())
    }
}
