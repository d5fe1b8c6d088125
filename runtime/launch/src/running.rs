//! Runs a cell for the command line, with the observers that draw its picture: on the memory link, or as processes.
//!
//! In: an assembled cell, a picture of its run and the options. Out: the run, its picture, and an exit status.

use std::fs::OpenOptions;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Duration;

use super::files::unwritable;
use super::long_run::LongRunNotes;
use super::options::Options;
use super::outcome::{cell_refused, note, report, stopped, tell};
use super::outcome_file::{Outcome, write_outcome};
use super::panel;
use super::{Launch, Parts, Ran};
use mrroc_core::cell::{Cell, CellError, RunPicture, RunReport};
use mrroc_core::console::{Background, refused};
use mrroc_core::fault::Fault;

/// What to do where the picture cannot be written.
const INSTEAD: &str = "--picture, or --no-picture";

/// How long a process may compute without waiting: long enough for planning, which takes seconds.
const STUCK: Duration = Duration::from_secs(60);

/// Runs the cell to its end, and draws what moved, unless no picture is wanted.
pub(super) fn run(
    mut cell: Cell,
    mut picture: impl RunPicture,
    options: &Options,
    parts: &'static Parts,
) -> ExitCode {
    if let Some(file) = options.picture() {
        // Checked before the run, because a run may be long.
        if let Err(error) = OpenOptions::new().append(true).create(true).open(file) {
            return refused(&unwritable(file, &error, INSTEAD));
        }
        cell = picture.watch(cell);
    }
    if !options.quiet {
        let notes = LongRunNotes::begin().with_reset(cell.awaits_reset());
        cell = cell.also_on_step(notes.hook());
    }
    let (panel, cell) = panel::observe_run(parts.panel.filter(|_| options.panel), cell);
    let ran = cell.end_when_stuck(STUCK).run();
    if let (Some(file), Ok(_) | Err(CellError::Fault(_))) = (&options.outcome, &ran)
        && let Err(error) = write_outcome(file, &Outcome::of_memory_link(&ran))
    {
        report(&error);
        return ExitCode::FAILURE;
    }
    let ended = match ran {
        Ok(report) => conclude(Ok(report), picture, options),
        Err(CellError::Fault(fault)) => conclude(Err(fault), picture, options),
        Err(error) => return cell_refused(&error),
    };
    panel.map_or(ended, |panel| panel.show())
}

/// Runs the cell as processes, or the process that this is. The plant draws the picture, because it has the simulated
/// robots.
pub(super) fn watched(
    mut cell: Cell,
    mut picture: impl RunPicture,
    path: PathBuf,
    options: Options,
    parts: &'static Parts,
) -> ExitCode {
    // Neither the launcher nor a process that moves robots waits for a terminal; without a thread for that, messages are
    // written at once.
    let _output = Background::begin().ok();
    let quiet = options.quiet;
    let watching = options.picture().is_some();
    let launch = Launch {
        part: options.part.clone(),
        arguments: std::env::args_os().skip(1).collect(),
        recording: None,
        asked: None,
        panel: false,
        clock: options.clock(),
        spin: options.spin,
        cell: Some(path),
        outcome: options.outcome.clone(),
        quiet,
        watching,
        parts,
    };
    let draws = launch.is_here();
    // Checked before the run, and by the launcher only.
    let file = options.picture().filter(|_| !launch.is_part());
    let is_new = file.is_some_and(|file| !file.exists());
    if let Some(file) = file
        && let Err(error) = OpenOptions::new().append(true).create(true).open(file)
    {
        return refused(&unwritable(file, &error, INSTEAD));
    }
    if draws {
        // The program's own observers are in the EDPs.
        cell = picture.watch(cell.unobserved());
    }
    match launch.run(cell) {
        Ok(Ran::Part(status)) => status,
        Ok(Ran::Here(report)) => conclude(Ok(report), picture, &options),
        Err(CellError::Fault(fault)) if draws => conclude(Err(fault), picture, &options),
        Ok(Ran::Processes(_)) if quiet => ExitCode::SUCCESS,
        Ok(Ran::Processes(report)) => {
            if watching {
                note(
                    "no picture: processes draw drives that are simulated and do not look for their marks first, and this cell has \
                     none",
                );
                // What was made to see whether it can be written is not left empty.
                if let Some(file) = options.picture().filter(|_| is_new) {
                    let _ = std::fs::remove_file(file);
                }
            }
            tell(&report, None)
        }
        Err(CellError::Fault(fault)) => stopped(&fault),
        Err(error) => cell_refused(&error),
    }
}

/// Draws what moved, and prints how the run ended.
fn conclude(outcome: Result<RunReport, Fault>, mut picture: impl RunPicture, options: &Options) -> ExitCode {
    let drawn = options
        .picture()
        .map_or(Ok(()), |file| picture.save(file).map_err(|error| unwritable(file, &error, INSTEAD)));
    let ended = match outcome {
        Ok(_) if options.quiet => ExitCode::SUCCESS,
        Ok(report) => tell(&report, options.picture().filter(|_| drawn.is_ok())),
        Err(fault) => stopped(&fault),
    };
    match drawn {
        Ok(()) => ended,
        Err(error) => {
            report(&error);
            ExitCode::FAILURE
        }
    }
}
