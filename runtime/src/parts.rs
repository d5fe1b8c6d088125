//! The optional parts that this program was built with: the only place where features are tested.

use std::ffi::OsString;
use std::process::ExitCode;

use mrroc_core::cell::{Cell, CellError, RunPicture};
use mrroc_launch::cell_file::CellFile;
use mrroc_launch::{Launch, Parts};

#[cfg(feature = "recording")]
const RECORDING: Parts = Parts {
    recorder: Some(&mrroc_recording::Mcap),
    replay: Some(mrroc_recording::replay_command),
    processes: None,
    panel: None,
};
#[cfg(not(feature = "recording"))]
const RECORDING: Parts = Parts { recorder: None, replay: None, processes: None, panel: None };

#[cfg(all(feature = "processes", target_os = "linux"))]
const PROCESSES: Option<&'static dyn mrroc_launch::Processes> =
    Some(&mrroc_processes::OverSharedMemory { recorder: RECORDING.recorder });
#[cfg(not(all(feature = "processes", target_os = "linux")))]
const PROCESSES: Option<&'static dyn mrroc_launch::Processes> = None;

#[cfg(all(feature = "panel", target_os = "linux"))]
const PANEL: Option<&'static dyn mrroc_launch::Panel> = Some(&mrroc_panel::InBrowser);
#[cfg(not(all(feature = "panel", target_os = "linux")))]
const PANEL: Option<&'static dyn mrroc_launch::Panel> = None;

static PARTS: Parts = Parts { processes: PROCESSES, panel: PANEL, ..RECORDING };

/// The main function of a task program: `cell` makes a cell from `cell.toml`, and the cell is run with the options of
/// the command line.
///
/// With `--processes` the same executable is every process of the cell: each process calls `cell` again and runs its
/// own part of that cell. So `cell` must make the same cell at every call: it may read files, but it must not open
/// anything that only one process may have, and must not move anything. Real drives are best opened by the first call
/// of their driver, in their EDP. The picture watches simulated robots in the plant, which draws it when the run is
/// over. For a cell without simulated robots no picture is drawn.
///
/// ```no_run
/// # use mrroc::cell::RunPicture;
/// # use mrroc::prelude::*;
/// # fn cell(file: &CellFile) -> Result<Cell, CellError> { file.cell(&mrroc::cell_file::Kinds::new()) }
/// # fn film() -> impl RunPicture { struct R; impl RunPicture for R {
/// #     fn watch(&mut self, cell: Cell) -> Cell { cell }
/// #     fn save(&mut self, _: &std::path::Path) -> std::io::Result<()> { Ok(()) }
/// # } R }
/// # #[allow(unused)]
/// fn main() -> std::process::ExitCode {
///     mrroc::launch(cell, film())
/// }
/// ```
pub fn launch(cell: impl FnOnce(&CellFile) -> Result<Cell, CellError>, picture: impl RunPicture) -> ExitCode {
    mrroc_launch::launch(cell, picture, &PARTS)
}

/// How a task program with a command line of its own runs its cell, from the arguments after the program's name;
/// [`launch`] is for all others.
///
/// When the cell runs as processes, the launcher starts the program again for each process, with the same arguments. So
/// the program must read the arguments and put its cell together before it asks which process it is, and must not move
/// or write anything before that.
///
/// ```no_run
/// # fn cell(quick: bool) -> mrroc::cell::Cell { mrroc::cell::Cell::new(std::time::Duration::from_millis(2)) }
/// use mrroc::launch::Clock;
/// use mrroc::launch::{Ran, program};
///
/// fn main() -> std::process::ExitCode {
///     let mut launch = program(std::env::args_os().skip(1));
///     if let Some(status) = launch.operate() {
///         return status;
///     }
///     let mut quick = false;
///     for argument in launch.arguments().to_vec() {
///         match argument.to_str() {
///             Some("--quick") => quick = true,
///             Some("--processes") => launch = launch.processes(Clock::Real),
///             _ => return std::process::ExitCode::from(2),
///         }
///     }
///     match launch.run(cell(quick)) {
///         Ok(Ran::Here(report) | Ran::Processes(report)) => println!("{} steps", report.steps),
///         Ok(Ran::Part(status)) => return status,
///         Err(error) => eprintln!("{error}"),
///     }
///     std::process::ExitCode::SUCCESS
/// }
/// ```
#[must_use]
pub fn program(arguments: impl IntoIterator<Item = OsString>) -> Launch {
    Launch::new(arguments, &PARTS)
}
