//! Recordings: what is in the file, that a replay demands the same, and that nothing slow or broken reaches the step.

mod allocation;
mod camera;
mod cell;
mod cells_of_cells;
mod command;
mod contents;
mod files;
#[cfg(target_os = "linux")]
mod frames;
mod peer;
#[cfg(target_os = "linux")]
mod processes;
mod replay;
mod slow;

use std::path::{Path, PathBuf};

/// Records a run to a file of this name.
fn recorded(name: &str) -> PathBuf {
    let file = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    let cell = cell::arms(cell::Change::Nothing).record(mrroc::recording::to(&file));
    cell.run().expect("keeps the limits");
    file
}
