//! The operator's command line for a cell that runs in another terminal.
//!
//! In: a word of the command line, or lines of a console. Out: requests to the cell; on the terminal its answers, and
//! an exit status.

use std::fmt::Write;
use std::io::{self, BufRead};
use std::path::Path;
use std::process::ExitCode;

use mrroc_core::console::{refused, say};
use mrroc_core::fault::Name;
use mrroc_core::operator::request::Addressed;
use mrroc_core::operator::state::InstructionKind;
use mrroc_core::operator::{Answer, Request};
use mrroc_launch::Operating;
use mrroc_launch::outcome::report;

use super::caller::Caller;
use super::holding::hold;
use super::picture::Picture;
use super::protocol::ConsoleMessage;
use crate::board::figures::Figures;

/// Sends a request to the running cell of the file at `cell`, or to the lower cell `of` in it, and prints the answer.
pub(crate) fn operate(cell: &Path, of: Option<Name>, operating: Operating) -> ExitCode {
    let caller = match Caller::find(cell) {
        Ok(caller) => caller.of(of),
        Err(error) => return refused(&error),
    };
    match operating {
        Operating::Ask(request) => once(caller, &request),
        Operating::Console => converse(caller),
        Operating::Hold(jog) => hold(caller, jog),
    }
}

/// Sends one request and prints its answer.
fn once(mut caller: Caller, request: &Request) -> ExitCode {
    match caller.ask(request, None) {
        Ok(ConsoleMessage::Picture(picture)) => say(&describe(&picture)),
        Ok(ConsoleMessage::Answer(answer)) => tell(&answer),
        Err(error) => {
            report(&error);
            ExitCode::FAILURE
        }
    }
}

fn tell(answer: &Answer) -> ExitCode {
    match answer {
        Answer::Done(text) => say(&format!("{text}\n")),
        Answer::Refused(text) => {
            // A refusal is printed in the same place as any other answer, so that scripts read both alike.
            let _ = say(&format!("refused: {text}\n"));
            ExitCode::FAILURE
        }
        Answer::Pending(text) => {
            let _ = say(&format!("pending: {text}\n"));
            ExitCode::from(3)
        }
    }
}

/// Sends one request for each line, over one connection, which may hold the control token until it ends. A line `of press reset`
/// is for a lower cell, whichever the connection is for.
fn converse(mut caller: Caller) -> ExitCode {
    let own = caller.asks.cell();
    for line in io::stdin().lock().lines() {
        let Ok(line) = line else { break };
        let addressed = Addressed::read(&line);
        let request = addressed.map(|Addressed { cell, request, .. }| {
            caller.asks.of(cell.or(own));
            request
        });
        match request {
            // A console prints one answer after another: it asks again for each picture.
            Ok(Request::Watch) => {
                let _ = tell(&Answer::Refused("write status".to_owned()));
            }
            Err(refused) => {
                let _ = tell(&Answer::Refused(refused.in_a_line()));
            }
            Ok(request) => match caller.ask(&request, None) {
                Ok(ConsoleMessage::Picture(picture)) => drop(say(&describe(&picture))),
                Ok(ConsoleMessage::Answer(answer)) => drop(tell(&answer)),
                Err(error) => {
                    report(&error);
                    return ExitCode::FAILURE;
                }
            },
        }
    }
    ExitCode::SUCCESS
}

/// A picture in words.
fn describe(picture: &Picture) -> String {
    let mut text = String::new();
    let millis = |nanos: u64| nanos as f64 * 1e-6;
    // Writing to a text does not fail.
    let mut line = |words: std::fmt::Arguments<'_>| {
        let _ = writeln!(text, "{words}");
    };
    line(format_args!("{}: step {} of {} ms", picture.state.word(), picture.step, millis(picture.period)));
    match picture.doing {
        InstructionKind::Nothing => {
            line(format_args!("instruction {}: over; the program computes", picture.instructions))
        }
        doing => {
            line(format_args!("instruction {}: {} {}", picture.instructions, doing.word(), picture.by_whom()))
        }
    }
    line(format_args!(
        "speed {:.0} %, rate {:.3}{}",
        100.0 * picture.speed,
        picture.rate,
        picture.reduction()
    ));
    match picture.holder {
        Some(holder) => line(format_args!("control: the console of process {holder}")),
        None => line(format_args!("control: nobody")),
    }
    line(format_args!("last fault: {}", picture.fault.as_deref().unwrap_or("none")));
    if let Some(persisting) = &picture.persisting {
        line(format_args!("a reset failed or would be refused: {persisting}"));
    }
    for cell in &picture.cells {
        let (step, period, fault) = (cell.step, millis(cell.period), cell.fault.as_deref().unwrap_or("none"));
        let (word, doing) = (cell.state.word(), cell.doing.word());
        let (rate, speed) = (cell.rate, 100.0 * cell.speed);
        line(format_args!("cell {}: {word}: step {step} of {period} ms, {doing} {}", cell.name, cell.by));
        line(format_args!("  speed {speed:.0} %, rate {rate:.3}; last fault: {fault}"));
    }
    line(format_args!(
        "{:>8} {:28} {:>8} {:>8} {:>8} {:>18}",
        "number", "process", "steps", "skipped", "overruns", "late, p99, max [us]"
    ));
    for process in &picture.processes {
        let name = format!("{}{}", process.name, if process.runs { "" } else { " (ended)" });
        let Figures { late, worked, skipped, overruns, .. } = process.figures;
        let micros = |nanos: u64| nanos as f64 * 1e-3;
        line(format_args!(
            "{:>8} {name:28} {:>8} {skipped:>8} {overruns:>8} {:>9.1}{:>9.1}",
            process.pid,
            worked.count,
            micros(late.p99),
            micros(late.max)
        ));
    }
    for robot in &picture.robots {
        line(format_args!("{} at {:.3} s{}", robot.name, robot.time, robot.motion()));
        line(format_args!("  demanded{}", joints(&robot.demanded)));
        line(format_args!("  measured{}", joints(&robot.measured)));
    }
    text
}

fn joints(positions: &[f64]) -> String {
    positions.iter().map(|q| format!(" {q:9.5}")).collect()
}
