//! The task programs that tests start as processes of their own; a variable of the environment names the one to be.

#![cfg(target_os = "linux")]

mod arms;
mod belt;
mod calls;
mod crowd;
mod recorded;
mod records;
mod soak;
mod tasks;

use std::io;
use std::path::Path;
use std::process::ExitCode;

use mrroc::cell::Cell;
use mrroc::cell::RunPicture;
use mrroc_counting_allocator::Counting;
use mrroc_tests::fixture::{ARMS, CROWD, PROGRAM, RECORDED, SOAK, TASKS};

#[global_allocator]
static ALLOCATOR: Counting = Counting;

fn main() -> ExitCode {
    let program = std::env::var(PROGRAM).unwrap_or_default();
    match program.as_str() {
        ARMS => arms::main(),
        TASKS => tasks::main(),
        SOAK => soak::main(),
        CROWD => crowd::main(),
        RECORDED => recorded::main(),
        _ => {
            eprintln!(
                "error: no program `{program}`\n help: {PROGRAM}={ARMS}, {TASKS}, {SOAK}, {CROWD} or {RECORDED}"
            );
            ExitCode::FAILURE
        }
    }
}

/// Draws nothing.
struct Nothing;

impl RunPicture for Nothing {
    fn watch(&mut self, cell: Cell) -> Cell {
        cell
    }

    fn save(&mut self, _: &Path) -> io::Result<()> {
        Ok(())
    }
}
