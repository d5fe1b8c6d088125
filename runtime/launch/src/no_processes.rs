//! A program that was built without processes of the operating system.
//!
//! In: what would need them. Out: how to build it with them.

use std::path::Path;
use std::process::ExitCode;

use super::Launch;
use super::options::{Clock, Operating};
use super::program::Ran;
use mrroc_core::cell::{Cell, CellError};
use mrroc_core::console::refused;
use mrroc_core::model::fault::ProcessId;

const NO_PROCESSES: &str = "this program was built without processes\n help: on Linux, build it with mrroc's feature `processes`: \
                            cargo run --release --features mrroc/processes -- --processes";

pub(super) fn examine() -> ExitCode {
    refused(&NO_PROCESSES)
}

pub(super) fn operate(_: &Path, _: Operating) -> ExitCode {
    refused(&NO_PROCESSES)
}

pub(super) fn take_part(_: Cell, process: ProcessId, _: &Path, _: &Launch) -> Result<Ran, CellError> {
    Ok(Ran::Part(refused(&format!("{process}: {NO_PROCESSES}"))))
}

pub(super) fn launch_processes(_: Cell, _: Clock, _: Launch) -> Result<Ran, CellError> {
    Err(CellError::Processes(NO_PROCESSES.to_owned()))
}
