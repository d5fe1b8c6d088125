//! The launcher: starts a session and its processes, supervises them in real time or resumes them under the virtual
//! clock, and reports how the run ended.
//!
//! In: the cell, as the launcher puts it together, and a [`Plan`] of how to run it. Out: a report, or the first cause
//! of a stop. When the launcher returns, all processes are reaped and the session's files are removed.

use std::time::{Duration, Instant};

use super::latch_notes::LatchNotes;
use super::pacing::pace;
use super::process_set::{NoStart, Plan, ProcessSet, Start};
use super::supervision::{Supervision, Timeouts};
use crate::board::StateBoard;
use crate::board::figures::table;
use crate::consoles::{CONNECTIONS, ConsoleServer};
use crate::link::{Clock, Fabric, LinkError, make_management};
use crate::machine::capacity::{self, NoRoom};
use crate::machine::signals::Signals;
use crate::session::{CellLock, Private, Session, SessionError, prefix};
use mrroc_core::cell::Rest;
use mrroc_core::cell::{Cell, CellError, RunReport};
use mrroc_core::console::{Background, complain};
use mrroc_core::fault::ProcessId;
use mrroc_core::link::Nanos;
use mrroc_core::observe::NotRecorded;
use mrroc_core::observe::recording::CommandRecord;
use mrroc_launch::network::network;
use mrroc_launch::outcome_file::{Outcome, write_outcome};

/// How many times a launch is tried when processes die while they start.
const ATTEMPTS: u64 = 5;

/// How long the MP's program may compute without a Move or a Wait, unless the cell says otherwise: long enough for
/// planning, which takes seconds.
const COMPUTING: Duration = Duration::from_secs(60);

/// What is wrong where a cell has nodes and its program no network.
pub(crate) const NO_NETWORK: &str = "cell.toml has nodes, and this program has no network between them\n help: depend on mrroc-zenoh, and write \
                          mrroc::launch::nodes_over(&mrroc_zenoh::Zenoh) as the first line of main";

/// Why a cell did not run as processes, or did not run to its end.
#[derive(Debug, thiserror::Error)]
pub(crate) enum LaunchError {
    /// What is wrong with the cell, or the first cause of a stop.
    #[error(transparent)]
    Cell(#[from] CellError),
    /// The machine has too little shared memory or too few open files for the cell.
    #[error(transparent)]
    Room(#[from] NoRoom),
    /// The session could not be made.
    #[error(transparent)]
    Session(#[from] SessionError),
    /// A process could not be set up.
    #[error(transparent)]
    Start(#[from] NoStart),
    /// The state board of the session could not be made.
    #[error("no shared memory for the cell's state: {0}\n help: make capacity in /dev/shm")]
    Board(std::io::Error),
    /// Shared memory could not be made.
    #[error(transparent)]
    Link(#[from] LinkError),
    /// The cell is on several machines, and cannot be run so.
    #[error("{0}")]
    Nodes(String),
    /// The socket for the operator's consoles could not be made.
    #[error("the operator's socket cannot be made: {0}{help}", help = capacity::remedy(.0))]
    ConsoleServer(std::io::Error),
    /// The thread that writes messages could not be started.
    #[error("no thread for the launcher's messages: {0}")]
    Output(std::io::Error),
    /// The handlers of signals could not be registered.
    #[error("signals cannot be heard: {0}{help}", help = capacity::remedy(.0))]
    Signals(#[from] std::io::Error),
}

/// The result of a launch.
pub(crate) enum Launched {
    /// The run ended well.
    Ran(RunReport),
    /// The plant has reported the result of the run, success or failure, and has ended with this exit status.
    Told(u8),
}

/// Runs every process of a cell as a process of the operating system.
///
/// # Errors
/// [`LaunchError`]: what was refused, before any robot moves; or the first cause of a stop.
pub(crate) fn launch(cell: Cell, plan: &Plan) -> Result<Launched, LaunchError> {
    // Whoever supervises robots waits for no terminal.
    let _output = Background::begin().map_err(LaunchError::Output)?;
    let stop = cell.stop_limit();
    let awaits_reset = cell.awaits_reset();
    let cells_that_await_reset = cell.cells_that_await_reset();
    let computing = cell.watchdog_timeout().unwrap_or(COMPUTING);
    let hardware = cell.hardware();
    let recorder = cell.recorder();
    let recording = cell.recording().cloned().map(|recording| (recording, cell.layout()));
    if plan.nodes.is_some() {
        check_nodes(plan)?;
    }
    // The launcher puts the cell together to learn its processes, and runs none of them itself.
    let mut fabric = Fabric::new(ProcessId::MP, plan.clock);
    cell.put_on(&mut fabric)?;
    let lock = CellLock::take(&plan.cell, &hardware)?;
    capacity::check(fabric.places().len() + fabric.connections(), CONNECTIONS)?;
    let signals = Signals::hear(plan.clock)?;
    let mut epoch = 1;
    loop {
        let session = lock.session()?;
        let (board, shown) = make_shared(&session, fabric.places().len())
            .map_err(|error| session.check_names().err().map_or(error, Into::into))?;
        let relay = match (&recording, recorder) {
            (None, _) => None,
            (Some(_), None) => return Err(CellError::from(NotRecorded::NoFeature).into()),
            (Some((recording, layout)), Some(recorder)) => {
                let listening = recorder.listen(recording, layout, session.folder(), plan.clock);
                Some(listening.map_err(CellError::from)?)
            }
        };
        let fingerprint = fabric.fingerprint();
        let start = Start { plan, fingerprint, session: &session, epoch, signals: &signals };
        match ProcessSet::start(fabric.places(), stop, &start) {
            Ok(process_set) => {
                // Commands are recorded by the machine's clock, which a cell under the virtual clock does not have.
                let recorder = relay.as_ref().and(recorder).filter(|_| plan.clock == Clock::Real);
                let record = recorder.and_then(|recorder| recorder.commands(session.folder(), plan.clock));
                let console_server = open_console_server(&session, shown, &process_set, record)?;
                let run = match plan.clock {
                    Clock::Real => {
                        let timeout = Timeouts { stop, computing };
                        let lower =
                            cells_that_await_reset.iter().map(|cell| LatchNotes::of_lower(*cell)).collect();
                        let notes = (LatchNotes::new(awaits_reset), lower);
                        Supervision::new(&process_set, &signals, &console_server, &board, timeout, notes)
                            .run(plan.watched)
                    }
                    Clock::Virtual => pace(&process_set, &signals, console_server, stop)?,
                };
                let teller = if plan.watched { process_set.plant_over() } else { None };
                process_set.reap(teller, Instant::now() + process_set.closing());
                // All processes have ended, so all their messages have been sent.
                drop(relay);
                let figures = process_set.figures();
                if !plan.quiet && !figures.is_empty() {
                    complain(table(&figures).trim_end());
                }
                let (steps, time) = (run.steps, run.time);
                let outcome = run.outcome();
                if let Some(file) = &plan.outcome {
                    let processes = figures.iter().map(|(process, figures)| figures.punctuality(*process));
                    let (time, fault, processes) =
                        (time.as_secs_f64(), outcome.as_ref().err(), processes.collect());
                    let told = write_outcome(file, &Outcome { steps, time, fault, processes });
                    drop(told.inspect_err(|error| complain(&format!("error: {error}"))));
                }
                if outcome.is_err() && !plan.quiet {
                    process_set
                        .members
                        .iter()
                        .for_each(|member| member.rests.borrow().iter().for_each(tell_rest));
                }
                // Nothing moves any more, and only the plant has something left to do, which may wait for who reads its
                // messages: the cell may be launched again, and signals are the program's again.
                drop((session, lock, signals));
                let told =
                    teller.and_then(|plant| plant.conclude(steps, time.as_nanos() as Nanos, outcome.clone()));
                if let Some(status) = told {
                    return Ok(Launched::Told(status));
                }
                outcome.map_err(|fault| LaunchError::Cell(fault.into()))?;
                return Ok(Launched::Ran(RunReport { steps, time }));
            }
            Err(NoStart::Died(..)) if epoch < ATTEMPTS && !signals.ends() => epoch += 1,
            // Files that others have put under the cell's names explain any other error.
            Err(error) => return Err(session.check_names().err().map_or_else(|| error.into(), Into::into)),
        }
    }
}

/// Refuses a cell on several machines that could not run so.
fn check_nodes(plan: &Plan) -> Result<(), LaunchError> {
    let refused = |text: &str| Err(LaunchError::Nodes(text.to_owned()));
    if plan.clock == Clock::Virtual {
        return refused(
            "a cell on several machines runs in real time\n help: --processes; or leave [nodes] out of its cell.toml, or run it without \
             processes",
        );
    }
    match network() {
        Some(_) => Ok(()),
        None => refused(NO_NETWORK),
    }
}

/// Makes what all processes share: of the state board, on which they show what they do, one end for the launcher and one for its
/// console server.
pub(crate) fn make_shared(session: &Session, places: usize) -> Result<(StateBoard, StateBoard), LaunchError> {
    let _private = Private::begin();
    make_management(&prefix(session.number()))?;
    let make =
        || Ok((StateBoard::create(session.number(), places)?, StateBoard::open(session.number(), places)?));
    make().map_err(LaunchError::Board)
}

/// Opens the console server, to which the operator's consoles connect.
fn open_console_server(
    session: &Session,
    board: StateBoard,
    process_set: &ProcessSet,
    record: Option<Box<dyn CommandRecord>>,
) -> Result<ConsoleServer, LaunchError> {
    let seats = process_set.members.iter().map(|member| (member.id, member.pid()));
    ConsoleServer::open((session.folder(), session.cell()), board, seats, record)
        .map_err(LaunchError::ConsoleServer)
}

/// Prints how a robot came to a standstill after its demands had stopped.
fn tell_rest(rest: &Rest) {
    let Rest { edp, braked_after, stood_after } = rest;
    complain(&format!(
        "note: {edp}: its drives applied their brakes {braked_after} steps after the last demand; the robot stood \
         {stood_after} steps later"
    ));
}
