//! A replay: a cell's programs run again on what a recording holds.
//!
//! In: an assembled cell and a recording. Out: what the comparison of all demands came to; from the command line
//! `identical`, or the first demand that differs, and an exit status.

use std::path::Path;
use std::process::ExitCode;
use std::rc::Rc;

use mrroc_core::cell::{Cell, CellError};
use mrroc_core::console::{refused, say};
use mrroc_core::observe::witness::Witness;
use mrroc_launch::outcome::{cell_refused, report};

use crate::compare::{Compared, Comparison};
use crate::reader::{CutOff, NotReplayable, read};

/// A recording was not replayed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ReplayError {
    /// What is wrong with the file.
    #[error(transparent)]
    File(#[from] NotReplayable),
    /// What is wrong with the cell.
    #[error(transparent)]
    Cell(#[from] CellError),
}

/// A cell whose programs can be run again on a recording.
pub trait Replay {
    /// Runs the cell's programs again on what `file` has recorded, on the memory link: what robots measured, sensors read
    /// and the operator wanted comes from the file, in place of drivers and virtual sensors. Compares every demand with
    /// the recorded one, to the bit, up to the first that differs, or up to a fault that came from outside.
    ///
    /// # Errors
    /// [`ReplayError`]: the file is no recording of this cell, or not whole; or what is wrong with the cell.
    fn replay(self, file: impl AsRef<Path>, cut_off: CutOff) -> Result<Compared, ReplayError>;
}

impl Replay for Cell {
    fn replay(mut self, file: impl AsRef<Path>, cut_off: CutOff) -> Result<Compared, ReplayError> {
        let names = self.check()?;
        let recorded = Rc::new(read(file.as_ref(), &self.layout(), cut_off)?);
        let comparison = Rc::new(Comparison::with(Rc::clone(&recorded)));
        let witness: Rc<dyn Witness> = Rc::<Comparison>::clone(&comparison);
        match self.replaying(recorded).witnessed_by(witness).run_on_memory(&names) {
            // How it ends, the comparison tells: a recording may end before its programs do.
            Ok(_) | Err(CellError::Fault(_)) => Ok(comparison.outcome()),
            Err(error) => Err(error.into()),
        }
    }
}

/// Replays a recording for the command line; `partial`: one that was cut off as far as it goes.
pub fn replay_command(cell: Cell, file: &Path, partial: bool, quiet: bool) -> ExitCode {
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
