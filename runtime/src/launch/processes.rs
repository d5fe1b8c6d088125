//! A cell as processes of the operating system, from the command line.
//!
//! In: an assembled cell and the options. Out: the run of all its processes, or of the one that this is.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use super::options::Clock;
use super::outcome::{cell_refused, stopped};
use super::patience::Patience;
use crate::cell::{Cell, CellError, RunReport};
use crate::console::{refused, say};
use crate::fault::ProcessId;
use crate::link::iceoryx::Clock as LinkClock;
use crate::processes::{LaunchError, NoPart, Plan, launch};
use crate::realtime::Permission;

/// Runs one process of a cell for its launcher.
pub(super) fn take_part(mut cell: Cell, process: ProcessId, session: &Path, quiet: bool) -> ExitCode {
    if !quiet {
        cell = cell.also_on_step(Patience::new().notes());
    }
    match crate::processes::run(cell, process, session) {
        Ok(()) => ExitCode::SUCCESS,
        Err(NoPart::NoLauncher(_)) if session.is_dir() => ExitCode::FAILURE,
        Err(error @ NoPart::NoLauncher(_)) => refused(&error),
        // The launcher says it.
        Err(NoPart::Told(_)) => ExitCode::FAILURE,
    }
}

/// Runs all processes of a cell.
pub(super) fn launch_processes(
    cell: Cell,
    (clock, spin): (Clock, u64),
    path: PathBuf,
    quiet: bool,
) -> Result<RunReport, ExitCode> {
    let clock = match clock {
        Clock::Real => LinkClock::Real,
        Clock::Virtual => LinkClock::Virtual,
    };
    let permission = cell.realtime().map_or(Permission::BestEffort, |realtime| realtime.permission);
    launch(cell, &Plan { cell: path, clock, spin, permission, quiet }).map_err(|error| match error {
        LaunchError::Cell(CellError::Fault(fault)) => stopped(&fault),
        LaunchError::Cell(error) => cell_refused(&error),
        error => refused(&error),
    })
}

/// Says what this machine can do for processes.
pub(super) fn examine() -> ExitCode {
    say(&crate::processes::examine())
}
