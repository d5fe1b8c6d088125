//! The optional parts of a program: crates that record, replay, or run a cell as processes.
//!
//! In: the parts that a program was built with, from the facade `mrroc`. Out: what the command line calls, and how it says that a cell
//! is to run. The parts
//! are plain function pointers and traits, so that this crate needs no `cfg` for them.

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::rc::Rc;

use crate::cell_file::CellFile;
use mrroc_core::cell::{Cell, CellError, Nodes, RunReport};
use mrroc_core::fault::{Name, ProcessId};
use mrroc_core::link::Clock;
use mrroc_core::observe::layout::Layout;
use mrroc_core::observe::recording::{NotRecorded, Recorder};
use mrroc_core::observe::step_observer::StepObserver;

use crate::options::{AskedRecording, Operating};
use crate::telling::PartRequest;
use mrroc_core::console::refused as refuse;

/// Replays the recording of a file on a cell: whether as far as it goes (`--partial`), and whether without a word (`--quiet`).
pub type Replays = fn(cell: Cell, file: &Path, partial: bool, quiet: bool) -> ExitCode;

/// The optional parts that a program was built with; `None` for a part that it lacks.
#[derive(Clone, Copy, Debug, Default)]
pub struct Parts {
    /// Records runs: `--record FILE`, `[recording]` of `cell.toml`.
    pub recorder: Option<&'static dyn Recorder>,
    /// Replays a recording on a cell: `replay FILE`. The last two arguments are `--partial` and `--quiet`.
    pub replay: Option<Replays>,
    /// Runs cells as processes of the operating system: `--processes`.
    pub processes: Option<&'static dyn Processes>,
    /// Shows a cell in a browser: `--panel`, `panel`.
    pub panel: Option<&'static dyn Panel>,
}

/// Shows a cell in a browser, and lets an operator operate it there.
pub trait Panel: core::fmt::Debug + Sync {
    /// Shows the cell of the file at `cell`, which runs as processes, and operates it, until it ends.
    fn attend(&self, layout: Layout, cell: &Path) -> ExitCode;

    /// Shows a recording of a cell of this layout, until it is ended by a signal.
    fn play(&self, layout: Layout, recording: &Path) -> ExitCode;

    /// Begins to observe a run in this one process.
    fn observe_run(&self, layout: Layout) -> Rc<dyn RunObserver>;
}

/// An observer of a run in one process, which shows the run when it is over.
pub trait RunObserver: StepObserver {
    /// The run is over: shows it until this process is ended by a signal.
    fn show(&self) -> ExitCode;
}

/// How a task program with a command line of its own runs its cell; [`launch`](crate) is for all others.
///
/// When the cell runs as processes, the launcher starts the program again for each process, with the same arguments. So
/// the program must read the arguments and put its cell together before it asks which process it is, and must not move
/// or write anything before that.
#[derive(Clone, Debug)]
pub struct Launch {
    /// Which process of the cell this is, and the folder of its session, if a launcher has started it.
    pub part: Option<(ProcessId, PathBuf)>,
    /// The arguments with which the processes are started.
    pub arguments: Vec<OsString>,
    /// What the command line asks for concerning a recording.
    pub(super) recording: Option<AskedRecording>,
    /// What is asked of a robot or a sensor, by name, and nothing else.
    pub(super) asked: Option<(PartRequest, String)>,
    /// Whether the cell is shown in a browser.
    pub(super) panel: bool,
    /// By which clock the cell runs as processes; `None`: on the memory link.
    pub clock: Option<Clock>,
    /// How long a process polls for messages before it sleeps \[ns\].
    pub spin: u64,
    /// The file of the cell, or another path that identifies it; `None`: the program's own file.
    pub cell: Option<PathBuf>,
    /// The file for how the run ends, as JSON.
    pub outcome: Option<PathBuf>,
    /// Whether only errors are printed.
    pub quiet: bool,
    /// Whether the program watches robots and keeps something of the run.
    pub watching: bool,
    /// What the program was built with.
    pub(super) parts: &'static Parts,
}

/// The result of a run.
#[derive(Clone, Copy, Debug, PartialEq)]
#[must_use]
pub enum Ran {
    /// The cell ran on the memory link, in this process; or it ran as processes, and this is the process that has
    /// observed the robots ([`Launch::watching`]).
    Here(RunReport),
    /// The cell ran as processes, and this is their launcher.
    Processes(RunReport),
    /// This was one of the processes, or a replay; it is over and is to end with this status. Its messages have been
    /// printed, here or by another process.
    Part(ExitCode),
}

/// Runs and operates cells as processes of the operating system.
pub trait Processes: core::fmt::Debug + Sync {
    /// Prints what this machine can do for processes.
    fn examine(&self) -> ExitCode;

    /// Prints what the links between the machines of the cell in the file at `cell` can do.
    fn examine_links(&self, nodes: &Nodes, cell: &Path) -> ExitCode;

    /// Carries out what an operator wants of the cell of the file at `cell`, which runs already, or of the lower cell `of` in it.
    fn operate(&self, cell: &Path, of: Option<Name>, operating: Operating) -> ExitCode;

    /// Runs one process of a cell for its launcher.
    ///
    /// # Errors
    /// The first cause of a stop; only in a plant that is watched.
    fn take_part(
        &self,
        cell: Cell,
        process: ProcessId,
        session: &Path,
        how: &Launch,
    ) -> Result<Ran, CellError>;

    /// Has the processes of the node `name` in a cell that is started on another machine, until it is ended.
    fn node(&self, cell: Cell, name: &str, how: Launch) -> ExitCode;

    /// Runs all processes of a cell.
    ///
    /// # Errors
    /// [`CellError`]: what was refused, before any robot moves; or the first cause of a stop.
    fn launch(&self, cell: Cell, how: Launch) -> Result<Ran, CellError>;
}

const NO_PANEL: &str = "this program was built without the panel\n help: build it with mrroc's feature `panel`: \
                        cargo run --release --features mrroc/panel -- --processes --panel";

const NO_PROCESSES: &str = "this program was built without processes\n help: on Linux, build it with mrroc's feature `processes`: \
                            cargo run --release --features mrroc/processes -- --processes";

impl Parts {
    pub(crate) fn examine(&self) -> ExitCode {
        self.processes.map_or_else(|| refuse(&NO_PROCESSES), |processes| processes.examine())
    }

    /// The same, and what the links between machines can do, if the cell has any.
    pub(crate) fn examine_with(&self, cell: &Path) -> ExitCode {
        let examined = self.examine();
        let nodes = CellFile::read(cell).ok().and_then(|file| file.nodes().cloned());
        match (self.processes, nodes) {
            (Some(processes), Some(nodes)) => processes.examine_links(&nodes, cell),
            (None, _) | (_, None) => examined,
        }
    }

    pub(crate) fn operate(&self, cell: &Path, of: Option<Name>, operating: Operating) -> ExitCode {
        self.processes
            .map_or_else(|| refuse(&NO_PROCESSES), |processes| processes.operate(cell, of, operating))
    }

    pub(crate) fn take_part(
        &self,
        cell: Cell,
        process: ProcessId,
        session: &Path,
        how: &Launch,
    ) -> Result<Ran, CellError> {
        match self.processes {
            Some(processes) => processes.take_part(cell, process, session, how),
            None => Ok(Ran::Part(refuse(&format!("{process}: {NO_PROCESSES}")))),
        }
    }

    pub(crate) fn node(&self, cell: Cell, name: &str, how: Launch) -> ExitCode {
        match self.processes {
            Some(processes) => processes.node(cell, name, how),
            None => refuse(&NO_PROCESSES),
        }
    }

    pub(crate) fn launch(&self, cell: Cell, how: Launch) -> Result<Ran, CellError> {
        match self.processes {
            Some(processes) => processes.launch(cell, how),
            None => Err(CellError::Processes(NO_PROCESSES.to_owned())),
        }
    }

    pub(crate) fn replay(&self, cell: Cell, file: &Path, partial: bool, quiet: bool) -> ExitCode {
        match self.replay {
            Some(replay) => replay(cell, file, partial, quiet),
            None => refuse(&NotRecorded::NoFeature),
        }
    }

    /// The panel.
    ///
    /// # Errors
    /// The program was built without it; that has been told.
    pub(crate) fn panel(&self) -> Result<&'static dyn Panel, ExitCode> {
        self.panel.ok_or_else(|| refuse(&NO_PANEL))
    }

    /// Shows a cell that runs as processes, or a recording of it, in a browser.
    pub(crate) fn show(&self, cell: &Cell, file: &Path, recording: Option<&Path>) -> ExitCode {
        match (self.panel(), recording) {
            (Ok(panel), Some(recording)) => panel.play(cell.layout(), recording),
            (Ok(panel), None) => panel.attend(cell.layout(), file),
            (Err(status), _) => status,
        }
    }

    /// Gives the cell the recorder, if there is one.
    pub(crate) fn equip(&self, cell: Cell) -> Cell {
        match self.recorder {
            Some(recorder) => cell.recorded_by(recorder),
            None => cell,
        }
    }
}
