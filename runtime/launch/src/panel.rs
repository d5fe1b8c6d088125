//! The operator's panel of a run: `--panel`.
//!
//! In: the parts of the program, and how the cell runs. Out: one more process that shows the cell in a browser, a console like any
//! other; or why there is none.

use std::ffi::OsString;
use std::os::unix::process::CommandExt;
use std::process::{Child, Command, ExitCode};
use std::rc::Rc;
use std::time::Duration;

use super::outcome::report;
use super::parts::{Panel, Parts, RunObserver};
use mrroc_core::cell::Cell;
use mrroc_core::console::refused;
use mrroc_core::link::Clock;
use mrroc_core::observe::step_observer::StepObserver;

/// How often it is looked whether the panel has ended with its cell, and how many times at most.
const LOOK: Duration = Duration::from_millis(50);
const FAREWELL: u32 = 40;

/// A variable of the environment of a panel whose cell is being started: it is waited for.
pub const AWAITED: &str = "MRROC_PANEL_AWAITS";

/// Whether a run can be shown.
///
/// # Errors
/// The exit status; why not has been told.
pub(super) fn check(parts: &Parts, clock: Option<Clock>, is_dry: bool) -> Result<(), ExitCode> {
    parts.panel()?;
    if clock == Some(Clock::Virtual) {
        return Err(refused(
            &"the virtual clock waits for nobody who looks on\n help: --panel goes with --processes, or with a run without either",
        ));
    }
    if is_dry && clock.is_none() {
        return Err(refused(&"a dry run has no panel\n help: leave out --dry-run, or --panel"));
    }
    Ok(())
}

/// Lets the panel observe a run in this one process, if there is a panel; it shows the run when that is over.
pub(super) fn observe_run(
    panel: Option<&'static dyn Panel>,
    cell: Cell,
) -> (Option<Rc<dyn RunObserver>>, Cell) {
    let Some(panel) = panel.map(|panel| panel.observe_run(cell.layout())) else { return (None, cell) };
    let observer = Rc::clone(&panel) as Rc<dyn StepObserver>;
    (Some(panel), cell.observed_by(observer))
}

/// The process that has the panel: it ends with its cell, and not later than who started it.
#[must_use]
pub(super) struct PanelProcess(Option<Child>);

/// Starts this program once more with these arguments, as the process that has the panel. The cell runs all the same if it cannot
/// be started.
pub(super) fn begin(arguments: impl IntoIterator<Item = OsString>) -> PanelProcess {
    let started = std::env::current_exe().and_then(|program| {
        // In a group of its own: what is typed at the terminal is for the launcher, and the panel ends with the cell.
        Command::new(program).args(arguments).env(AWAITED, "1").process_group(0).spawn()
    });
    PanelProcess(started.inspect_err(|error| report(&format!("the panel cannot be started: {error}"))).ok())
}

impl Drop for PanelProcess {
    #[allow(clippy::disallowed_methods, reason = "a launcher whose cell is over is no part of control")]
    fn drop(&mut self) {
        let Some(child) = &mut self.0 else { return };
        for _ in 0..FAREWELL {
            if !matches!(child.try_wait(), Ok(None)) {
                return;
            }
            std::thread::sleep(LOOK);
        }
        // Its cell has not begun, or was never this one.
        let _ = child.kill();
        let _ = child.wait();
    }
}
