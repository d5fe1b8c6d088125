//! What the command line of a task program asks of this crate.
//!
//! In: an assembled cell and the options. Out: the run of all its processes, or of the one process that this is.

use std::io;
use std::path::Path;
use std::process::ExitCode;
use std::rc::Rc;

use mrroc_core::cell::{Cell, CellError, Nodes, Permission};
use mrroc_core::console::{Background, complain, refused, say};
use mrroc_core::fault::{Name, ProcessId, Role};
use mrroc_core::link::Clock;
use mrroc_core::observe::recording::{Recorder, RunRecord};
use mrroc_core::observe::ring::Ring;
use mrroc_core::observe::step_observer::StepObserver;
use mrroc_launch::long_run::LongRunNotes;
use mrroc_launch::{Launch, Operating, Processes, Ran};

use crate::consoles::operate;
use crate::diagnosis::doctor::examine;
use crate::launch::launcher::{LaunchError, Launched, launch};
use crate::launch::process_set::Plan;
use crate::member::{NoPart, run};
use crate::nodes::{carrier, link, runs};
use crate::picture_socket::{self, Receiver};

/// Cells as processes over shared memory.
#[derive(Clone, Copy, Debug)]
pub struct OverSharedMemory {
    /// What records the runs, if the program was built with it.
    pub recorder: Option<&'static dyn Recorder>,
}

impl Processes for OverSharedMemory {
    fn examine(&self) -> ExitCode {
        say(&examine())
    }

    fn examine_links(&self, nodes: &Nodes, cell: &Path) -> ExitCode {
        say(&link::examine(nodes, cell))
    }

    fn operate(&self, cell: &Path, of: Option<Name>, operating: Operating) -> ExitCode {
        operate(cell, of, operating)
    }

    fn take_part(
        &self,
        cell: Cell,
        process: ProcessId,
        session: &Path,
        how: &Launch,
    ) -> Result<Ran, CellError> {
        if process.role == Role::Node {
            return Ok(Ran::Part(carry(cell, process, session, how)));
        }
        take_part(self.recorder, cell, process, session, how)
    }

    fn node(&self, cell: Cell, name: &str, how: Launch) -> ExitCode {
        match how.cell.map_or_else(std::env::current_exe, Ok) {
            Ok(file) => runs::run(cell, name, file, (how.arguments, how.quiet)),
            Err(error) => refused(&error),
        }
    }

    fn launch(&self, cell: Cell, how: Launch) -> Result<Ran, CellError> {
        launch_processes(cell, how)
    }
}

/// Runs the process that carries messages to other machines.
fn carry(cell: Cell, me: ProcessId, session: &Path, how: &Launch) -> ExitCode {
    let _output = Background::begin().ok();
    let file = how.cell.clone().map_or_else(std::env::current_exe, Ok);
    match file.map(|file| carrier::run(cell, me, session, &file)) {
        Ok(Ok(())) => ExitCode::SUCCESS,
        Ok(Err(error @ NoPart::NoLauncher(_))) if !session.is_dir() => refused(&error),
        // The launcher prints the fault.
        Ok(Err(_)) => ExitCode::FAILURE,
        Err(error) => refused(&error),
    }
}

/// Runs one process of a cell for its launcher.
///
/// # Errors
/// The first cause of a stop; only in a plant that is watched.
fn take_part(
    recorder: Option<&'static dyn Recorder>,
    mut cell: Cell,
    process: ProcessId,
    session: &Path,
    how: &Launch,
) -> Result<Ran, CellError> {
    // A process that moves robots waits for no terminal. Without a thread for it, its messages are written at once.
    let _output = Background::begin().ok();
    if how.is_watched_plant() {
        cell = cell.watched_in_plant();
    }
    if !how.quiet {
        let notes = match how.clock {
            // Its launcher does not look at what the MP shows.
            Some(Clock::Virtual) => LongRunNotes::begin_operated().with_reset(cell.awaits_reset()),
            Some(Clock::Real) | None => LongRunNotes::begin_operated(),
        };
        cell = cell.also_on_step(notes.hook());
    }
    let record =
        recorder.and_then(|recorder| recorder.join(cell.recording(), &cell.layout(), process, session));
    if let Some(record) = &record {
        cell = cell.observed_in_all_cells_by(Rc::clone(record) as Rc<dyn StepObserver>);
    }
    let pictured = if how.watching { show_picture(&mut cell, process, session, how.clock) } else { None };
    if let Some(shown) = &pictured {
        cell = cell.observed_by(Rc::clone(shown) as Rc<dyn StepObserver>);
    }
    let subscriptions = cell.begin_subscriptions(Some(process), how.clock.unwrap_or(Clock::Real));
    for shown in &subscriptions {
        cell = cell.observed_by(Rc::clone(shown) as Rc<dyn StepObserver>);
    }
    let picture = if how.is_watched_plant() { open_picture(&mut cell, session) } else { None };
    let ran = run(cell, process, session, how.watching);
    // What the launcher's thread has not received yet, and the plant's.
    record.iter().chain(&subscriptions).for_each(|record| record.finish());
    pictured.iter().for_each(|shown| shown.finish());
    // When the plant gets the result of the run, all other processes have ended.
    if let (Some(picture), Ok(Some(_))) = (picture, &ran) {
        picture.finish();
    }
    Ok(Ran::Part(match ran {
        Ok(Some(Ok(report))) => return Ok(Ran::Here(report)),
        Ok(Some(Err(fault))) => return Err(fault.into()),
        Ok(None) => ExitCode::SUCCESS,
        Err(NoPart::NoLauncher(_)) if session.is_dir() => ExitCode::FAILURE,
        Err(error @ NoPart::NoLauncher(_)) => refused(&error),
        // The launcher prints the fault.
        Err(NoPart::Told(_)) => ExitCode::FAILURE,
    }))
}

/// Shows a picture in the plant what this process has, if the cell has a plant.
fn show_picture(
    cell: &mut Cell,
    process: ProcessId,
    session: &Path,
    clock: Option<Clock>,
) -> Option<Rc<Ring>> {
    let has_plant = cell.is_simulated();
    // A process that does not know its clock waits for nothing.
    has_plant.then(|| picture_socket::join(process, session, clock.unwrap_or(Clock::Real))).flatten()
}

/// Lets the observers of the picture see what the other processes show, if there are any.
fn open_picture(cell: &mut Cell, session: &Path) -> Option<Receiver> {
    let observers = cell.take_observers_of_picture();
    if observers.is_empty() {
        return None;
    }
    let opened = Receiver::open(session, cell.layout(), observers);
    let unseen =
        |error: &io::Error| complain(&format!("warning: the picture lacks what processes show: {error}"));
    opened.inspect_err(unseen).ok()
}

/// Runs all processes of a cell.
fn launch_processes(cell: Cell, how: Launch) -> Result<Ran, CellError> {
    let refused = |error: &dyn core::fmt::Display| CellError::Processes(error.to_string());
    let clock = how.clock.unwrap_or(Clock::Virtual);
    let file = how.cell.map_or_else(std::env::current_exe, Ok).map_err(|error| refused(&error))?;
    let permission = cell.realtime().map_or(Permission::BestEffort, |realtime| realtime.permission);
    let nodes = cell.nodes().cloned();
    let Launch { arguments, spin, quiet, watching: watched, outcome, .. } = how;
    let plan = Plan { cell: file, arguments, clock, spin, permission, quiet, watched, nodes, outcome };
    match launch(cell, &plan) {
        Ok(Launched::Ran(report)) => Ok(Ran::Processes(report)),
        Ok(Launched::Told(status)) => Ok(Ran::Part(ExitCode::from(status))),
        Err(LaunchError::Cell(error)) => Err(error),
        Err(error) => Err(refused(&error)),
    }
}
