//! A replay: runs a cell's programs again on the contents of a recording.
//!
//! In: an assembled cell and a recording. Out: the result of comparing all demands; on the command line
//! `identical`, or the first demand that differs, and an exit status.

use std::path::Path;
use std::process::ExitCode;
use std::rc::Rc;

use mrroc_core::cell::{Cell, CellError};
use mrroc_core::console::{refused, say};
use mrroc_core::observe::step_observer::StepObserver;
use mrroc_launch::outcome::{cell_refused, report};

use crate::compare::{Compared, Comparison};
use crate::reader::read;
use crate::wrong::{CutOff, NotReplayable};

/// Why a recording was not replayed.
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
    /// Runs the cell's programs again on the recording in `file`, on the memory link. The file replaces drivers,
    /// virtual sensors and the operator: measured states, readings and what the operator wanted come from it. Every
    /// demand is compared with the recorded demand, to the bit, up to the first difference, or up to a fault that came
    /// from outside.
    ///
    /// # Errors
    /// [`ReplayError`]: the file is no recording of this cell or is not complete; or what is wrong with the cell.
    fn replay(self, file: impl AsRef<Path>, cut_off: CutOff) -> Result<Compared, ReplayError>;
}

impl Replay for Cell {
    fn replay(mut self, file: impl AsRef<Path>, cut_off: CutOff) -> Result<Compared, ReplayError> {
        let names = self.check()?;
        let recorded = Rc::new(read(file.as_ref(), &self.layout(), cut_off)?);
        let comparison = Rc::new(Comparison::with(Rc::clone(&recorded)));
        let observer: Rc<dyn StepObserver> = Rc::<Comparison>::clone(&comparison);
        match self.replaying(recorded).observed_by(observer).run_on_memory(&names) {
            // A fault is no error here: the comparison tells how the replay ended, and a recording may end before its
            // programs do.
            Ok(_) => Ok(comparison.outcome(None)),
            Err(CellError::Fault(fault)) => Ok(comparison.outcome(Some(&fault))),
            Err(error) => Err(error.into()),
        }
    }
}

/// Replays a recording for the command line; with `partial` also one that was cut off, up to its last complete step.
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
            let with = compared.fault.as_ref().map(|fault| format!(" with: {fault}")).unwrap_or_default();
            report(&format!(
                "{file}: the program ends after {steps} steps{with}; the recording goes on to step {last}"
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
