//! Pictures of the cell as diagnostics.

use core::time::Duration;

use mrroc_core::operator::CellState;
use mrroc_core::operator::state::InstructionKind;
use mrroc_processes::Picture;

use crate::messages::{DiagnosticStatus, ERROR, KeyValue, OK, WARN};

/// The time between two diagnostics in which nothing new is told.
pub const EVERY: Duration = Duration::from_secs(1);

/// The present instruction of the coordinator, and the generator or condition of that.
pub fn instruction(picture: &Picture) -> String {
    let by = if picture.doing == InstructionKind::Nothing { "" } else { picture.by_whom() };
    format!("{} {by}", picture.doing.word()).trim_end().to_owned()
}

/// The status of the cell, and of each of its processes.
pub fn of(picture: &Picture, node: &str) -> Vec<DiagnosticStatus> {
    let pair = |key: &str, value: String| KeyValue { key: key.to_owned(), value };
    let level = match picture.state {
        CellState::Idle | CellState::Running => OK,
        CellState::Suspended | CellState::Aborting | CellState::Resetting => WARN,
        CellState::Stopping | CellState::Latched | CellState::Acknowledged => ERROR,
    };
    let mut values = vec![
        pair("step", picture.step.to_string()),
        pair("rate of path time", picture.rate.to_string()),
        pair("speed", picture.speed.to_string()),
        pair("reduced speed", picture.reduced.to_string()),
        pair("instruction", instruction(picture)),
    ];
    values.extend(picture.holder.map(|holder| pair("control", format!("process {holder}"))));
    values.extend(picture.help.iter().map(|help| pair("help", help.clone())));
    let cell = DiagnosticStatus {
        level,
        name: node.to_owned(),
        message: picture.fault.clone().unwrap_or_else(|| picture.state.word().to_owned()),
        hardware_id: String::new(),
        values,
    };
    let processes = picture.processes.iter().map(|process| DiagnosticStatus {
        level: if process.runs { OK } else { ERROR },
        name: format!("{node}: {}", process.name),
        message: if process.runs { "runs" } else { "has ended" }.to_owned(),
        hardware_id: String::new(),
        values: vec![pair("process", process.pid.to_string())],
    });
    core::iter::once(cell).chain(processes).collect()
}
