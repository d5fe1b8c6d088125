//! A dry run: runs the whole program under the virtual clock, with all limits and guards, before any robot has power.
//!
//! In: an assembled cell. Out: how long the program takes and how near it comes to the limits; or the fault that stops
//! it, or a motion that could not be suspended on its path.

use std::path::Path;
use std::process::{Command, ExitCode};
use std::rc::Rc;

use super::long_run::LongRunNotes;
use super::outcome::{cell_refused, note, report, stand_ins, stopped};
use crate::approach::Approach;
use mrroc_core::cell::AfterFault;
use mrroc_core::cell::{Cell, CellError};
use mrroc_core::console::{complain, refused, say};

/// Runs a cell dry.
pub(super) fn dry_run(mut cell: Cell, quiet: bool) -> ExitCode {
    let layout = cell.layout();
    let stood_in: String = stand_ins(&layout).map(|told| told + "\n").collect();
    let approach = Rc::new(Approach::of(layout));
    let observer: Rc<Approach> = Rc::clone(&approach);
    // There is nobody who could reset it.
    cell = cell.unrecorded().observed_by(observer).after_fault(AfterFault::End);
    if !quiet {
        cell = cell.also_on_step(LongRunNotes::begin_dry().hook());
    }
    match cell.run() {
        Ok(ran) => {
            if let Some(too_near) = approach.too_near() {
                complain(&format!("dry run: how near it came to its limits\n{stood_in}{approach}"));
                return refused(&too_near);
            }
            if quiet {
                return ExitCode::SUCCESS;
            }
            if ran.steps == 0 {
                note("nothing moved: the program returned before a Move or a Wait");
            }
            let (seconds, steps) = (ran.time.as_secs_f64(), ran.steps);
            say(&format!("dry run: {seconds:.3} s in {steps} steps within all limits\n{stood_in}{approach}"))
        }
        Err(CellError::Fault(fault)) => {
            complain(&format!(
                "dry run: how near it came to its limits until the fault\n{stood_in}{approach}"
            ));
            stopped(&fault)
        }
        Err(error) => cell_refused(&error),
    }
}

/// Runs this program dry in a process of its own, so that whatever its programs change in their own process does not
/// reach the real run.
///
/// # Errors
/// The exit status, if the dry run failed: then no robot has moved.
pub(super) fn dry_run_first(cell: &Path, quiet: bool) -> Result<(), ExitCode> {
    let started = std::env::current_exe().and_then(|program| {
        let mut command = Command::new(program);
        command.arg("--dry-run").arg("--cell").arg(cell);
        if quiet {
            command.arg("--quiet");
        }
        command.status()
    });
    match started {
        Ok(status) if status.success() => Ok(()),
        Ok(_) => {
            report(&"the dry run did not go well: nothing is started");
            Err(ExitCode::from(2))
        }
        Err(error) => {
            report(&format!("the dry run cannot be started: {error}"));
            Err(ExitCode::from(2))
        }
    }
}
