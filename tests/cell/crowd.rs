//! The task program of the test of large cells: robots that stand, as many as the cell's file has, until a file appears.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use mrroc::launch::own_option;
use mrroc::prelude::*;
use mrroc_tests::fixture::RECORDS;

use crate::Nothing;

/// Runs it under the options of the command line.
pub fn main() -> ExitCode {
    let cell = |file: &CellFile| Ok(file.cell(&mrroc_robots::simulated())?.program(stand));
    mrroc::launch(cell, Nothing)
}

fn stand(mp: &mut Mp) -> Result<(), Fault> {
    let folder = own_option(RECORDS).ok_or_else(|| Fault::thrown("no folder for records"))?;
    let ended = Ended { file: Path::new(&folder).join("end") };
    mp.wait_until((), (), ended).map(drop)
}

/// Until there is a file.
struct Ended {
    file: PathBuf,
}

#[condition(mp)]
fn ended(c: &mut Ended) -> bool {
    c.file.exists()
}
