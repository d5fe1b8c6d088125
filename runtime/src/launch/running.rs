//! A cell on the memory link, from the command line.
//!
//! In: an assembled cell, its recorder and the options. Out: a run, a picture of it, and an exit status.

use std::fs::OpenOptions;
use std::io;
use std::path::Path;
use std::process::ExitCode;
use std::time::Duration;

use super::Recorder;
use super::options::Options;
use super::outcome::{cell_refused, report, stopped, tell};
use super::patience::Patience;
use crate::cell::{Cell, CellError};
use crate::console::refused;

/// How long a process may compute at a stretch: planning takes seconds, an endless loop for ever.
const STUCK: Duration = Duration::from_secs(60);

/// Runs the cell to its end, and draws what moved unless told not to.
pub(super) fn run(mut cell: Cell, mut recorder: impl Recorder, options: &Options) -> ExitCode {
    if let Some(picture) = &options.picture {
        // Found out now, not after a long run.
        if let Err(error) = OpenOptions::new().append(true).create(true).open(picture) {
            return refused(&unwritable(picture, &error));
        }
        cell = recorder.watch(cell);
    }
    if !options.quiet {
        cell = cell.also_on_step(Patience::new().notes());
    }
    let outcome = match cell.end_when_stuck(STUCK).run() {
        Ok(report) => Ok(report),
        Err(CellError::Fault(fault)) => Err(fault),
        Err(error) => return cell_refused(&error),
    };
    let drawn = options
        .picture
        .as_ref()
        .map_or(Ok(()), |picture| recorder.save(picture).map_err(|error| unwritable(picture, &error)));
    let ended = match outcome {
        Ok(_) if options.quiet => ExitCode::SUCCESS,
        Ok(report) => tell(&report, options.picture.as_deref().filter(|_| drawn.is_ok())),
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

fn unwritable(picture: &Path, error: &io::Error) -> String {
    let picture = picture.display();
    format!("{picture}: cannot be written: {error}\n help: give another file by --picture, or --no-picture")
}
