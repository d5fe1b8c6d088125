//! A cell as processes of the operating system, from the command line.
//!
//! In: an assembled cell and the options. Out: the run of all its processes, or of the one that this is.

use std::path::Path;
use std::process::ExitCode;
use std::rc::Rc;

use super::Launch;
pub(super) use super::operating::operate;
use super::options::Clock;
use super::patience::Patience;
use crate::cell::{Cell, CellError, RunReport};
use crate::console::{refused, say};
use crate::fault::ProcessId;
use crate::link::iceoryx::Clock as LinkClock;
use crate::processes::{LaunchError, NoPart, Plan, launch};
use crate::realtime::Permission;
use crate::recording::Recorder;
use crate::recording::relay::join;

/// Runs one process of a cell for its launcher.
pub(super) fn take_part(mut cell: Cell, process: ProcessId, session: &Path, quiet: bool) -> ExitCode {
    if !quiet {
        cell = cell.also_on_step(Patience::new().notes());
    }
    let recorder = join(&cell, process, session);
    if let Some(recorder) = &recorder {
        let witness: Rc<Recorder> = Rc::clone(recorder);
        cell = cell.witnessed_by(witness);
    }
    let ran = crate::processes::run(cell, process, session);
    // What the launcher's thread has not got yet.
    recorder.iter().for_each(|recorder| recorder.finish());
    match ran {
        Ok(()) => ExitCode::SUCCESS,
        Err(NoPart::NoLauncher(_)) if session.is_dir() => ExitCode::FAILURE,
        Err(error @ NoPart::NoLauncher(_)) => refused(&error),
        // The launcher says it.
        Err(NoPart::Told(_)) => ExitCode::FAILURE,
    }
}

/// Runs all processes of a cell.
pub(super) fn launch_processes(cell: Cell, clock: Clock, how: Launch) -> Result<RunReport, CellError> {
    let refused = |error: &dyn core::fmt::Display| CellError::Processes(error.to_string());
    let clock = match clock {
        Clock::Real => LinkClock::Real,
        Clock::Virtual => LinkClock::Virtual,
    };
    let file = how.cell.map_or_else(std::env::current_exe, Ok).map_err(|error| refused(&error))?;
    let permission = cell.realtime().map_or(Permission::BestEffort, |realtime| realtime.permission);
    let Launch { arguments, spin, quiet, .. } = how;
    let plan = Plan { cell: file, arguments, clock, spin, permission, quiet };
    launch(cell, &plan).map_err(|error| match error {
        LaunchError::Cell(error) => error,
        error => refused(&error),
    })
}

/// Says what this machine can do for processes.
pub(super) fn examine() -> ExitCode {
    say(&crate::processes::examine())
}
