//! The task program of the test of large cells: robots that stand, as many as the cell's file has, until a file appears.

use std::path::Path;
use std::process::ExitCode;
use std::time::Duration;

use mrroc::launch::own_option;
use mrroc::prelude::*;
use mrroc_tests::fixture::RECORDS;

use crate::Nothing;

/// Runs it under the options of the command line.
pub fn main() -> ExitCode {
    let cell = |file: &CellFile| {
        let cell = file.cell(&mrroc_robots::simulated())?.program(stand);
        // Its program computes until it is told to end.
        Ok(cell.end_when_stuck(Duration::from_secs(600)))
    };
    mrroc::launch(cell, Nothing)
}

fn stand(_: &mut Mp) -> Result<(), Fault> {
    let folder = own_option(RECORDS).ok_or_else(|| Fault::thrown("no folder for records"))?;
    while !Path::new(&folder).join("end").exists() {
        std::thread::sleep(Duration::from_millis(10));
    }
    Ok(())
}
