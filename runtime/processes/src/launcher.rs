//! The launcher: starts a session and its processes, supervises them in real time or resumes them under the virtual
//! clock, and reports how the run ended.
//!
//! In: the cell, as the launcher puts it together, and a [`Plan`] of how to run it. Out: a report, or the first cause
//! of a stop. When the launcher returns, all processes are reaped and the session's files are removed.

use std::io::Read;
use std::os::fd::AsFd;
use std::os::unix::net::UnixStream;
use std::rc::Rc;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};

use super::board::StateBoard;
use super::capacity::{self, NoRoom};
use super::console_server::ConsoleServer;
use super::control::Frame;
use super::figures::table;
use super::process_set::{Member, NoStart, Over, Plan, ProcessSet};
use super::session::{CellLock, Private, Session, SessionError, prefix};
use crate::iceoryx::{Clock, Fabric, LinkError, make_management, monotonic};
use mrroc_core::cell::Rest;
use mrroc_core::cell::{Cell, CellError, RunReport, first_cause};
use mrroc_core::fault::{Fault, ProcessId, Role};
use mrroc_core::link::memory::Scheduler;
use mrroc_core::link::{Link, Nanos, Waiter};
use mrroc_core::observe::NotRecorded;

/// How many times a launch is tried when processes die while they start.
const ATTEMPTS: u64 = 5;

/// Time from GO to the beginning of step 0, long enough for all processes to receive GO.
const HEAD_START: Duration = Duration::from_millis(20);

/// Time that processes have to end after the cell closes, in addition to the time that its robots take to stop.
const CLOSING: Duration = Duration::from_secs(10);

/// Time that the MP's program has to end after an abort, in addition to the time that its robots take to stop.
const ABORTING: Duration = Duration::from_secs(5);

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
    /// The socket for the operator's consoles could not be made.
    #[error("the operator's socket cannot be made: {0}{help}", help = capacity::remedy(.0))]
    ConsoleServer(std::io::Error),
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
    let stop = cell.stop_limit();
    let recorder = cell.recorder();
    let recording = cell.recording().cloned().map(|recording| (recording, cell.layout()));
    // The launcher puts the cell together to learn its processes, and runs none of them itself.
    let mut fabric = Fabric::new(ProcessId::MP, plan.clock);
    cell.put_on(&mut fabric)?;
    let lock = CellLock::take(&plan.cell)?;
    capacity::check(fabric.places().len() + fabric.ways())?;
    let signals = Signals::hear()?;
    let mut epoch = 1;
    loop {
        let session = lock.session()?;
        let board = make_shared(plan.clock, &session, fabric.places().len())
            .map_err(|error| session.check_names().err().map_or(error, Into::into))?;
        let relay = match (&recording, recorder) {
            (None, _) => None,
            (Some(_), None) => return Err(CellError::from(NotRecorded::NoFeature).into()),
            (Some((recording, layout)), Some(recorder)) => {
                let listening = recorder.listen(recording, layout, session.folder(), plan.clock);
                Some(listening.map_err(CellError::from)?)
            }
        };
        match ProcessSet::start(fabric.places(), fabric.fingerprint(), &session, epoch, plan) {
            Ok(process_set) => {
                let run = match board {
                    Some(board) => supervise(
                        &process_set,
                        &signals,
                        &open_desk(&session, board, &process_set)?,
                        (stop, plan.watched),
                    ),
                    None => pace(&process_set, &signals, stop)?,
                };
                let teller = if plan.watched { process_set.plant_over() } else { None };
                process_set.reap(teller, Instant::now() + CLOSING);
                // All processes have ended, so all their messages have been sent.
                drop(relay);
                let figures = process_set.figures();
                if !plan.quiet && !figures.is_empty() {
                    eprint!("{}", table(&figures));
                }
                let (steps, time) = (run.steps, run.time);
                let outcome = run.outcome();
                if outcome.is_err() && !plan.quiet {
                    process_set.0.iter().for_each(|member| member.rests.borrow().iter().for_each(tell_rest));
                }
                let told =
                    teller.and_then(|plant| plant.conclude(steps, time.as_nanos() as Nanos, outcome.clone()));
                if let Some(status) = told {
                    return Ok(Launched::Told(status));
                }
                outcome.map_err(|fault| LaunchError::Cell(fault.into()))?;
                return Ok(Launched::Ran(RunReport { steps, time }));
            }
            Err(NoStart::Died(..)) if epoch < ATTEMPTS && !signals.came() => epoch += 1,
            // Files that others have put under the cell's names explain any other error.
            Err(error) => return Err(session.check_names().err().map_or_else(|| error.into(), Into::into)),
        }
    }
}

/// Makes what all processes share. In real time, this is also the state board on which they show what they do; `None`
/// under the virtual clock, where consoles cannot watch the cell.
fn make_shared(clock: Clock, session: &Session, places: usize) -> Result<Option<StateBoard>, LaunchError> {
    let _private = Private::begin();
    make_management(session.folder(), &prefix(session.number()))?;
    match clock {
        Clock::Real => StateBoard::create(session.number(), places).map(Some).map_err(LaunchError::Board),
        Clock::Virtual => Ok(None),
    }
}

/// Opens the console server, to which the operator's consoles connect.
fn open_desk(
    session: &Session,
    board: StateBoard,
    process_set: &ProcessSet,
) -> Result<ConsoleServer, LaunchError> {
    let seats = process_set.0.iter().map(|member| (member.id, member.pid()));
    ConsoleServer::open(session.folder(), board, seats).map_err(LaunchError::ConsoleServer)
}

/// The result of a run.
struct Run {
    /// The first process that died.
    death: Option<Fault>,
    outcomes: Vec<(ProcessId, Result<(), Fault>)>,
    steps: u64,
    time: Duration,
}

impl Run {
    fn of(process_set: &ProcessSet, death: Option<Fault>, time: Option<Nanos>) -> Run {
        let overs: Vec<_> = process_set
            .0
            .iter()
            .filter_map(|member| Some((member.id, member.over.borrow().clone()?)))
            .collect();
        let mp = overs.iter().find(|(id, _)| *id == ProcessId::MP).map(|(_, over)| over);
        let time = time.or_else(|| mp.map(|over| over.time)).unwrap_or(0);
        Run {
            death,
            steps: mp.map_or(0, |over| over.steps),
            time: Duration::from_nanos(time),
            outcomes: overs.into_iter().filter_map(|(id, over)| Some((id, over.outcome?))).collect(),
        }
    }

    fn outcome(self) -> Result<(), Fault> {
        match self.death {
            Some(death) => Err(death),
            None => first_cause(&self.outcomes),
        }
    }
}

/// The signals that ask the launcher to end, such as Ctrl-C: the first one is an abort, after which the cell closes,
/// whatever its program does; the second one ends the launcher at once.
struct Signals {
    came: Arc<AtomicBool>,
    wakes: UnixStream,
}

impl Signals {
    fn hear() -> std::io::Result<Signals> {
        let came = Arc::new(AtomicBool::new(false));
        let (wakes, waker) = UnixStream::pair()?;
        wakes.set_nonblocking(true)?;
        for signal in [SIGINT, SIGTERM, SIGHUP] {
            // The shutdown is registered before the flag is set: the first signal finds the flag clear, the second one
            // finds it set.
            signal_hook::flag::register_conditional_shutdown(signal, 130, Arc::clone(&came))?;
            signal_hook::flag::register(signal, Arc::clone(&came))?;
            signal_hook::low_level::pipe::register(signal, waker.try_clone()?)?;
        }
        Ok(Signals { came, wakes })
    }

    fn came(&self) -> bool {
        self.came.load(Ordering::Acquire)
    }
}

/// Runs a cell in real time: receives what its processes send, and returns when all of them have ended or died.
fn supervise(
    process_set: &ProcessSet,
    signals: &Signals,
    console_server: &ConsoleServer,
    (stop, watched): (Duration, bool),
) -> Run {
    process_set.tell(&Frame::Go { origin: monotonic() + HEAD_START.as_nanos() as Nanos });
    let mut death: Option<Fault> = None;
    let (mut aborting, mut closing): (Option<Instant>, Option<Instant>) = (None, None);
    let close = |closing: &mut Option<Instant>| {
        closing.get_or_insert_with(|| {
            process_set.tell(&Frame::Close);
            Instant::now() + stop + CLOSING
        });
    };
    loop {
        let waits = |member: &Member| watched && member.id.role == Role::Plant && member.is_over();
        let left: Vec<_> =
            process_set.0.iter().filter(|member| !member.gone.get() && !waits(member)).collect();
        if left.is_empty() {
            return Run::of(process_set, death, None);
        }
        let rest = closing.or(aborting).map(|until| until.saturating_duration_since(Instant::now()));
        if rest == Some(Duration::ZERO) {
            match closing {
                Some(_) => left.iter().for_each(|member| {
                    member.kill();
                    if member.over.borrow().is_none() {
                        death.get_or_insert(member.death("it did not end when the cell closed"));
                    }
                }),
                // The MP's program still computes, or goes on although it was aborted.
                None => close(&mut closing),
            }
            continue;
        }
        let (signalled, spoke) = wait(&left, signals, console_server, rest);
        if signalled {
            process_set.tell_mp(&Frame::Abort);
            aborting.get_or_insert(Instant::now() + stop + ABORTING);
        }
        console_server.presses().for_each(|press| process_set.tell_mp(&press));
        for member in spoke {
            match member.control.receive() {
                Ok(Frame::Over { steps, time, outcome }) => {
                    member.over.replace(Some(Over { steps, time, outcome }));
                    console_server.ended(member.id);
                    if member.id == ProcessId::MP {
                        close(&mut closing);
                    }
                }
                Ok(Frame::Rested(rest)) => member.rests.borrow_mut().push(rest),
                Ok(Frame::Figures(figures)) => {
                    member.figures.set(Some(figures));
                    console_server.measured(member.id, figures);
                }
                Ok(_) => {}
                Err(_) => {
                    let how = member.reap();
                    console_server.ended(member.id);
                    if member.over.borrow().is_some() {
                        continue;
                    }
                    match member.id.role {
                        // Processes that read this sensor notice its loss; all others go on.
                        Role::Vsp => note(member, &how),
                        Role::Mp => {
                            death.get_or_insert(member.death(&how));
                            close(&mut closing);
                        }
                        Role::Ecp | Role::Edp | Role::Plant => {
                            death.get_or_insert(member.death(&how));
                            process_set.tell_mp(&Frame::Lost(member.id));
                        }
                    }
                }
            }
        }
    }
}

/// Waits, for at most `time`, until a signal comes, a button is pressed, or a process sends a frame or ends. Returns
/// whether a signal came, and the processes of which something came.
fn wait<'a>(
    left: &[&'a Rc<Member>],
    signals: &Signals,
    console_server: &ConsoleServer,
    time: Option<Duration>,
) -> (bool, Vec<&'a Rc<Member>>) {
    let mut all: Vec<_> = left
        .iter()
        .map(|member| PollFd::from_borrowed_fd(member.control.descriptor(), PollFlags::IN))
        .collect();
    all.push(PollFd::from_borrowed_fd(console_server.descriptor(), PollFlags::IN));
    all.push(PollFd::from_borrowed_fd(signals.wakes.as_fd(), PollFlags::IN));
    let time = time.and_then(|time| Timespec::try_from(time).ok());
    if poll(&mut all, time.as_ref()).is_err() {
        // A signal interrupted the call; the next wait sees it.
        return (false, Vec::new());
    }
    let came: Vec<_> = all.iter().map(|descriptor| !descriptor.revents().is_empty()).collect();
    let signalled = came.last().copied().unwrap_or(false);
    if signalled {
        drop((&signals.wakes).read(&mut [0; 64]));
    }
    (signalled, left.iter().zip(came).filter(|(_, came)| *came).map(|(member, _)| *member).collect())
}

fn note(member: &Member, how: &str) {
    eprintln!("note: {}: {how}", member.id);
}

/// Prints how a robot came to a standstill after its demands had stopped.
fn tell_rest(rest: &Rest) {
    let Rest { edp, braked_after, stood_after } = rest;
    eprintln!(
        "note: {edp}: its drives applied their brakes {braked_after} steps after the last demand; the robot stood \
         {stood_after} steps later"
    );
}

/// Runs a cell in lock-step under the virtual clock: the memory link's scheduler resumes processes in place of
/// coroutines, one at a time and in the same order, so that the run is the same as on the memory link.
fn pace(process_set: &ProcessSet, signals: &Signals, stop: Duration) -> Result<Run, CellError> {
    process_set.tell(&Frame::Go { origin: 0 });
    let mut scheduler = Scheduler::new();
    let places: Vec<_> = process_set.0.iter().map(|member| scheduler.place(member.id)).collect();
    let death = Rc::new(core::cell::RefCell::new(None));
    for (member, place) in process_set.0.iter().zip(places) {
        let proxy = Proxy {
            member: Rc::clone(member),
            wake: scheduler.waker(),
            close: scheduler.closer(),
            stopped: Arc::clone(&signals.came),
            death: Rc::clone(&death),
            stop: stop.as_nanos() as Nanos,
            all: process_set.0.clone(),
            place,
        };
        scheduler.body(place, Box::new(move |host| proxy.run(host.waiter)))?;
    }
    let time = scheduler.run()?;
    let death = death.take();
    Ok(Run::of(process_set, death, Some(time)))
}

/// Represents a process in the scheduler of the launcher.
struct Proxy {
    member: Rc<Member>,
    wake: Box<dyn Fn(u64)>,
    close: Box<dyn Fn()>,
    stopped: Arc<AtomicBool>,
    death: Rc<core::cell::RefCell<Option<Fault>>>,
    /// How long robots may take to stop \[ns\].
    stop: Nanos,
    /// All processes by their places, and the place of this process.
    all: Vec<Rc<Member>>,
    place: usize,
}

impl Proxy {
    fn run(&self, waiter: &dyn Waiter) {
        let mp = self.member.id == ProcessId::MP;
        // In lock-step a process sends nothing while its program computes, however long that takes.
        drop(self.member.control.wait_for_ever());
        let mut frame = Frame::Resume { now: waiter.now() };
        loop {
            let mut answered = self.member.control.send(&frame).and_then(|()| self.member.control.receive());
            while let Ok(Frame::Rested(rest)) = answered {
                self.member.rests.borrow_mut().push(rest);
                answered = self.member.control.receive();
            }
            match answered {
                Ok(Frame::Waits { deadline, woken }) => {
                    (self.wake)(woken);
                    if mp && self.stopped.load(Ordering::Acquire) {
                        (self.close)();
                    }
                    let open = waiter.wait(Some(deadline)).is_ok();
                    frame = if open { Frame::Resume { now: waiter.now() } } else { Frame::Close };
                }
                Ok(Frame::Calls { place, woken }) => {
                    (self.wake)(woken);
                    self.call(place, waiter.now());
                    frame = Frame::Resume { now: waiter.now() };
                }
                Ok(Frame::Over { steps, time, outcome }) => {
                    self.member.over.replace(Some(Over { steps, time, outcome }));
                    if mp {
                        (self.close)();
                    }
                    return;
                }
                Ok(_) | Err(_) => return self.mourn(waiter, mp),
            }
        }
    }

    /// Lets the process at a place run until it waits, as if it were a part of the calling process.
    fn call(&self, place: u64, now: Nanos) {
        let Some(called) = usize::try_from(place).ok().and_then(|place| self.all.get(place)) else { return };
        if called.gone.get() || called.over.borrow().is_some() {
            return;
        }
        match called.control.send(&Frame::Resume { now }).and_then(|()| called.control.receive()) {
            // The calling process goes on at once, so it needs no wake-up.
            Ok(Frame::Waits { woken, .. }) => (self.wake)(woken & !(1 << self.place)),
            // The called process is gone: its own proxy notices that when it is resumed.
            Ok(_) | Err(_) => (self.wake)(1 << place),
        }
    }

    /// Reports the death of the process. When the MP has died, the robots stop by themselves, and then the cell closes.
    fn mourn(&self, waiter: &dyn Waiter, mp: bool) {
        let how = self.member.reap();
        if self.member.id.role == Role::Vsp {
            return note(&self.member, &how);
        }
        self.death.borrow_mut().get_or_insert(self.member.death(&how));
        let until = waiter.now() + self.stop;
        while mp && waiter.now() < until && waiter.wait(Some(until)).is_ok() {}
        if mp {
            (self.close)();
        }
    }
}
