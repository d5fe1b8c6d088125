//! The cell of the tests of recordings as a task program; its swing may be another one from some path time on.

#[allow(dead_code, reason = "the tests use the rest")]
#[path = "../recording/cell.rs"]
mod cell;

#[allow(dead_code, reason = "the tests use the rest")]
#[path = "../recording/camera.rs"]
mod camera;

use std::process::ExitCode;

use mrroc::launch::own_option;
use mrroc::prelude::*;
use mrroc_tests::fixture::CHANGE;

use crate::Nothing;
use cell::{Change, Counting, programmed};

pub fn main() -> ExitCode {
    mrroc::launch(assemble, Nothing)
}

fn assemble(file: &CellFile) -> Result<Cell, CellError> {
    let change = own_option(CHANGE).and_then(|text| text.parse().ok());
    let cell = file
        .cell(&mrroc_robots::simulated())?
        .sensor(file.sensor("count", Counting::default())?)
        .sensor(file.sensor("slow", Counting::default())?)
        .sensor(file.sensor("free", Counting::default())?);
    // Only some of the tests have a camera in their file.
    Ok(match file.sensor("camera", camera::Camera::new(4)) {
        Ok(setup) => cell.sensor(setup).program(camera::look),
        Err(_) => programmed(cell, change.map_or(Change::Nothing, Change::Swing)),
    })
}
