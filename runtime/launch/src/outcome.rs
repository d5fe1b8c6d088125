//! What a task program prints at its end.
//!
//! In: a report, a fault or a refusal. Out: lines on the terminal, and an exit status.

use std::fmt::Display;
use std::path::Path;
use std::process::ExitCode;

use mrroc_core::cell::{CellError, RunReport};
use mrroc_core::console::{complain, quoted, say};
use mrroc_core::fault::Fault;
use mrroc_core::observe::layout::{HardwareLayout, Layout};

/// Prints which fault stopped the cell and what to do about it.
pub fn stopped(fault: &Fault) -> ExitCode {
    match fault.help() {
        Some(help) => report(&format!("{fault}\n help: {help}")),
        None => report(fault),
    }
    ExitCode::FAILURE
}

/// Prints how long a run took and where its picture is.
pub fn tell(report: &RunReport, picture: Option<&Path>) -> ExitCode {
    let (seconds, steps) = (report.time.as_secs_f64(), report.steps);
    if steps == 0 {
        note("nothing moved: the program returned before a Move or a Wait");
    }
    let picture = picture.map_or_else(String::new, |picture| format!(": see {}", picture.display()));
    say(&format!("ran {seconds:.3} s in {steps} steps{picture}\n"))
}

/// Prints all that is wrong with a cell.
pub fn cell_refused(error: &CellError) -> ExitCode {
    match error {
        CellError::Several(errors) => errors.iter().for_each(|one| report(one)),
        one => report(one),
    }
    ExitCode::from(2)
}

/// Prints, instead of a run, the help that was asked for, or what is wrong with the command line.
pub fn answered(answer: &clap::Error) -> ExitCode {
    let text = answer.to_string();
    if answer.use_stderr() {
        complain(text.trim_end());
        return ExitCode::from(2);
    }
    say(&text)
}

/// Which simulated drives and sensors stand in for real ones: a sentence for each.
pub(crate) fn stand_ins(layout: &Layout) -> impl Iterator<Item = String> + '_ {
    let robots = layout.robots.iter().map(|robot| (&robot.name, &robot.drives, "simulated drives"));
    let sensors = layout.sensors.iter().map(|sensor| (&sensor.name, &sensor.hardware, "a simulated sensor"));
    robots.chain(sensors).filter_map(|(name, hardware, what)| match hardware {
        HardwareLayout::StandIn(hardware) => {
            Some(format!("{name}: {what} stood in for {}", quoted(hardware, 120)))
        }
        HardwareLayout::Nothing | HardwareLayout::Real(_) | HardwareLayout::Simulator(_) => None,
    })
}

/// Prints an error.
pub fn report(error: &dyn Display) {
    complain(&format!("error: {error}"));
}

/// Prints a note.
pub(crate) fn note(text: &str) {
    complain(&format!("note: {text}"));
}
