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
use super::program::Ran;
use mrroc_core::cell::{Cell, CellError};
use mrroc_core::console::{refused, say};
use mrroc_core::model::fault::ProcessId;
use mrroc_core::link::iceoryx::Clock as LinkClock;
use mrroc_processes::{LaunchError, Launched, NoPart, Plan, launch};
use mrroc_core::cell::realtime::Permission;
use mrroc_recording::Recorder;
use mrroc_recording::relay::join;

/// Runs one process of a cell for its launcher.
///
/// # Errors
/// In a plant that is watched: the first cause of a stop.
pub(super) fn take_part(
    mut cell: Cell,
    process: ProcessId,
    session: &Path,
    how: &Launch,
) -> Result<Ran, CellError> {
    if how.is_watched_plant() {
        cell = cell.watched_in_plant();
    }
    if !how.quiet {
        cell = cell.also_on_step(Patience::new().notes());
    }
    let recorder = join(&cell, process, session);
    if let Some(recorder) = &recorder {
        let witness: Rc<Recorder> = Rc::clone(recorder);
        cell = cell.witnessed_by(witness);
    }
    let ran = mrroc_processes::run(cell, process, session, how.watching);
    // What the launcher's thread has not got yet.
    recorder.iter().for_each(|recorder| recorder.finish());
    Ok(Ran::Part(match ran {
        Ok(Some(Ok(report))) => return Ok(Ran::Here(report)),
        Ok(Some(Err(fault))) => return Err(fault.into()),
        Ok(None) => ExitCode::SUCCESS,
        Err(NoPart::NoLauncher(_)) if session.is_dir() => ExitCode::FAILURE,
        Err(error @ NoPart::NoLauncher(_)) => refused(&error),
        // The launcher says it.
        Err(NoPart::Told(_)) => ExitCode::FAILURE,
    }))
}

/// Runs all processes of a cell.
pub(super) fn launch_processes(cell: Cell, clock: Clock, how: Launch) -> Result<Ran, CellError> {
    let refused = |error: &dyn core::fmt::Display| CellError::Processes(error.to_string());
    let clock = match clock {
        Clock::Real => LinkClock::Real,
        Clock::Virtual => LinkClock::Virtual,
    };
    let file = how.cell.map_or_else(std::env::current_exe, Ok).map_err(|error| refused(&error))?;
    let permission = cell.realtime().map_or(Permission::BestEffort, |realtime| realtime.permission);
    let Launch { arguments, spin, quiet, watching: watched, .. } = how;
    let plan = Plan { cell: file, arguments, clock, spin, permission, quiet, watched };
    match launch(cell, &plan) {
        Ok(Launched::Ran(report)) => Ok(Ran::Processes(report)),
        Ok(Launched::Told(status)) => Ok(Ran::Part(ExitCode::from(status))),
        Err(LaunchError::Cell(error)) => Err(error),
        Err(error) => Err(refused(&error)),
    }
}

/// Says what this machine can do for processes.
pub(super) fn examine() -> ExitCode {
    say(&mrroc_processes::examine())
}
