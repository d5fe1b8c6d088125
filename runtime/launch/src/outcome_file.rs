//! How a run ended, as a file for programs: tests, scripts, a plant's records.
//!
//! In: the outcome of a run and, of processes in real time, how punctual each was. Out: one JSON object. A run that is late for its machine
//! says so there in figures, so that nobody has to read it out of messages.

use std::fmt::Write;
use std::path::Path;

use mrroc_core::cell::{CellError, RunReport};
use mrroc_core::fault::{Fault, ProcessId};

use crate::files::unwritable;

/// A distribution of times of one process \[ns\].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Times {
    /// The median.
    pub p50: u64,
    /// The 99th percentile.
    pub p99: u64,
    /// The 99.9th percentile.
    pub p99_9: u64,
    /// The longest.
    pub max: u64,
}

/// How punctual a process was.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Punctuality {
    /// Which one.
    pub process: ProcessId,
    /// Steps, servo periods, orders or readings that it worked on.
    pub steps: u64,
    /// Periods that it left out.
    pub skipped: u64,
    /// Steps for which it took a period or more.
    pub overruns: u64,
    /// How late its steps or servo periods began.
    pub late: Times,
    /// How long it worked on each.
    pub worked: Times,
}

/// How a run ended.
#[derive(Clone, Debug)]
pub struct Outcome<'a> {
    /// Steps of the MP.
    pub steps: u64,
    /// Time on the cell's clock \[s\].
    pub time: f64,
    /// The first cause of its stop, if it did not end well.
    pub fault: Option<&'a Fault>,
    /// The processes of a cell in real time. Nothing else can be late.
    pub processes: Vec<Punctuality>,
}

impl<'a> Outcome<'a> {
    /// Of a run on the memory link.
    pub(crate) fn of_memory_link(ran: &'a Result<RunReport, CellError>) -> Outcome<'a> {
        let (steps, time) = ran.as_ref().map_or((0, 0.0), |report| (report.steps, report.time.as_secs_f64()));
        let fault = match ran {
            Err(CellError::Fault(fault)) => Some(fault),
            Ok(_) | Err(_) => None,
        };
        Outcome { steps, time, fault, processes: Vec::new() }
    }

    /// As one JSON object. Times are in seconds.
    #[must_use]
    pub fn json(&self) -> String {
        let Outcome { steps, time, fault, processes } = self;
        let fault = fault.map_or_else(|| "null".to_owned(), of_fault);
        let longest = processes.iter().map(|process| process.late.max).max().unwrap_or(0);
        let skipped: u64 = processes.iter().map(|process| process.skipped).sum();
        let mut text = format!("{{\"steps\":{steps},\"time\":{time},\"fault\":{fault},");
        // Writing to a text does not fail.
        let _ = write!(text, "\"skipped\":{skipped},\"longest_stall\":{},\"processes\":[", seconds(longest));
        for (nth, process) in processes.iter().enumerate() {
            let Punctuality { process, steps, skipped, overruns, late, worked } = process;
            let separator = if nth == 0 { "" } else { "," };
            let process = quoted(&process.to_string());
            let _ = write!(
                text,
                "{separator}\n{{\"process\":{process},\"steps\":{steps},\"skipped\":{skipped},\"overruns\":{overruns},\"late\":{},\"worked\":{}}}",
                of_times(late),
                of_times(worked)
            );
        }
        text.push_str("]}\n");
        text
    }
}

fn of_fault(fault: &Fault) -> String {
    let or_null = |text: Option<String>| text.unwrap_or_else(|| "null".to_owned());
    format!(
        "{{\"kind\":{},\"process\":{},\"step\":{},\"text\":{}}}",
        quoted(&format!("{:?}", fault.kind())),
        or_null(fault.process().map(|process| quoted(&process.to_string()))),
        or_null(fault.step().map(|step| step.to_string())),
        quoted(&fault.to_string())
    )
}

fn of_times(times: &Times) -> String {
    let [p50, p99, p99_9, max] = [times.p50, times.p99, times.p99_9, times.max].map(seconds);
    format!("{{\"p50\":{p50},\"p99\":{p99},\"p99.9\":{p99_9},\"max\":{max}}}")
}

fn seconds(nanos: u64) -> f64 {
    nanos as f64 / 1e9
}

/// A text in JSON.
fn quoted(text: &str) -> String {
    let mut quoted = String::from('"');
    for c in text.chars() {
        match c {
            '"' | '\\' => quoted.extend(['\\', c]),
            // Writing to a text does not fail.
            c if c.is_control() => drop(write!(quoted, "\\u{:04x}", u32::from(c))),
            c => quoted.push(c),
        }
    }
    quoted + "\""
}

/// Writes it.
///
/// # Errors
/// What to tell the user.
pub fn write_outcome(file: &Path, outcome: &Outcome<'_>) -> Result<(), String> {
    std::fs::write(file, outcome.json()).map_err(|error| unwritable(file, &error, "--outcome"))
}

/// Checks, before a run, that its outcome can be written. It leaves no file where there was none: that would be the outcome of no run.
///
/// # Errors
/// It cannot be.
pub(crate) fn check_outcome(file: &Path) -> Result<(), String> {
    let mut options = std::fs::OpenOptions::new();
    let made = options.write(true).create_new(true).open(file).and_then(|_| std::fs::remove_file(file));
    let checked = match made {
        // What is there, or where a link leads, stays as it is.
        Err(error) if error.kind() == std::io::ErrorKind::AlreadyExists => {
            options.create_new(false).create(true).open(file).map(drop)
        }
        made => made,
    };
    checked.map_err(|error| unwritable(file, &error, "--outcome"))
}

#[cfg(test)]
mod tests {
    use mrroc_core::fault::FaultKind;

    use super::*;

    #[test]
    fn an_outcome_is_one_object_with_the_fault_and_the_figures_of_each_process() {
        let fault =
            Fault::new(FaultKind::Overrun).in_process(ProcessId::MP).at_step(7).text("11 of \"10\"\n");
        let late = Times { p50: 1_000, p99: 2_000, p99_9: 5_000, max: 3_000_000 };
        let mp = Punctuality {
            process: ProcessId::MP,
            steps: 8,
            skipped: 2,
            overruns: 1,
            late,
            worked: Times::default(),
        };
        let outcome = Outcome { steps: 8, time: 0.5, fault: Some(&fault), processes: vec![mp, mp] };
        let json = outcome.json();
        let begins =
            r#"{"steps":8,"time":0.5,"fault":{"kind":"Overrun","process":"mp","step":7,"text":"mp: "#;
        assert!(json.starts_with(begins), "{json}");
        assert!(json.contains(r#"11 of \"10\""#) && !json.contains("10\"\n"), "{json}");
        assert!(json.contains(r#""skipped":4,"longest_stall":0.003,"processes":["#), "{json}");
        assert_eq!(
            json.matches(r#""late":{"p50":0.000001,"p99":0.000002,"p99.9":0.000005,"max":0.003}"#).count(),
            2,
            "{json}"
        );
        let good = Outcome { fault: None, processes: Vec::new(), ..outcome };
        assert!(
            good.json().contains(r#""fault":null,"skipped":0,"longest_stall":0,"processes":[]}"#),
            "{}",
            good.json()
        );
    }
}
