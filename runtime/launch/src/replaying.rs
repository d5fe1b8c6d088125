//! A replay, from the command line.
//!
//! In: an assembled cell and a recording. Out: `identical`, or the first demand that differs, and an exit status.

use std::path::Path;
use std::process::ExitCode;

use super::outcome::{cell_refused, report};
use mrroc_core::cell::Cell;
use mrroc_core::console::{refused, say};
use mrroc_recording::{CutOff, ReplayError};
use mrroc_core::control::replay::compare::Compared;

/// Replays a recording.
pub(super) fn replay(cell: Cell, file: &Path, partial: bool, quiet: bool) -> ExitCode {
    let cut_off = if partial { CutOff::Taken } else { CutOff::Refused };
    let compared = match cell.replay(file, cut_off) {
        Ok(compared) => compared,
        Err(ReplayError::File(error)) => return refused(&error),
        Err(ReplayError::Cell(error)) => return cell_refused(&error),
    };
    let steps = compared.steps;
    if compared.is_identical() {
        let end = ending(&compared);
        return if quiet { ExitCode::SUCCESS } else { say(&format!("{steps} steps: identical{end}\n")) };
    }
    match (&compared.difference, compared.longer) {
        (Some(difference), _) => report(&format!("{}: {difference}", file.display())),
        (None, Some(last)) => {
            let file = file.display();
            report(&format!(
                "{file}: the program ends after {steps} steps, the recording goes on to step {last}"
            ));
        }
        (None, None) => report(&format!("{}: no demand was made", file.display())),
    }
    ExitCode::FAILURE
}

/// How the recorded run ended.
fn ending(compared: &Compared) -> String {
    match (&compared.outside, &compared.end) {
        (Some(fault), _) => format!(", up to what came from outside: {fault}"),
        (None, Some(None)) => String::new(),
        (None, Some(Some(fault))) => format!("; the recorded run ended with: {fault}"),
        (None, None) => ", as far as the recording goes".to_owned(),
    }
}
