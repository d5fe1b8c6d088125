//! The task programs that tests start as processes of their own; an option behind `--` names the one to be.

#![cfg(target_os = "linux")]

#[path = "../tutorial/tcp_servo/arm.rs"]
mod arm;
mod arms;
mod belt;
mod calls;
mod crowd;
mod line;
#[path = "../tutorial/tcp_servo/mp.rs"]
mod mp;
mod readers;
mod recorded;
mod records;
mod remote;
mod soak;
mod tasks;

use std::io;
use std::path::Path;
use std::process::ExitCode;
use std::sync::Arc;

use mrroc::cell::Cell;
use mrroc::cell::RunPicture;
use mrroc::fault::ProcessId;
use mrroc::launch::own_option;
use mrroc::observe::step_observer::{StepEvent, StepObserver};
use mrroc_counting_allocator::Counting;
use mrroc_tests::fixture::{
    ARMS, CROWD, LINE, PROGRAM, RECORDED, REMOTE, SERVO, SOAK, SUSPENDED, TAKES_NOTHING, TASKS,
};

#[global_allocator]
static ALLOCATOR: Counting = Counting;

fn main() -> ExitCode {
    let program = own_option(PROGRAM).unwrap_or_default();
    match program.as_str() {
        ARMS => arms::main(),
        TASKS => tasks::main(),
        SOAK => soak::main(),
        CROWD => crowd::main(),
        LINE => line::main(),
        RECORDED => recorded::main(),
        REMOTE => remote::main(),
        SERVO => mrroc::launch(|file| Ok(file.cell(&arm::kinds())?.program(mp::coordinate)), Nothing),
        _ => {
            eprintln!(
                "error: no program `{program}`\n help: -- --{PROGRAM} {ARMS}, {TASKS}, {SOAK}, {CROWD}, {LINE}, {RECORDED}, {REMOTE} or {SERVO}"
            );
            ExitCode::FAILURE
        }
    }
}

/// A cell that its operator suspends in the step that [`SUSPENDED`] gives: it stands on its path until a console resumes it, however
/// long that takes.
fn suspended(cell: Cell) -> Cell {
    let Some(at) = own_option(SUSPENDED).and_then(|step| step.parse::<u64>().ok()) else { return cell };
    cell.also_on_step(move |step, operator| {
        if step == at {
            operator.suspend();
        }
    })
}

/// Draws nothing, but is shown what a picture needs.
struct Nothing;

impl RunPicture for Nothing {
    fn watch(&mut self, cell: Cell) -> Cell {
        cell.shown_to_picture(Arc::new(Nothing))
    }

    fn save(&mut self, _: &Path) -> io::Result<()> {
        Ok(())
    }
}

impl StepObserver for Nothing {
    fn see(&self, _: u64, _: ProcessId, _: &StepEvent, _: &[u64]) {
        while own_option(TAKES_NOTHING).is_some() {
            std::thread::park();
        }
    }
}
