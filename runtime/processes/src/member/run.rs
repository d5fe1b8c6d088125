//! One process of a cell.
//!
//! In: the session's folder, and frames of the launcher. Out: the run of this process's part of the cell; to the
//! launcher, how that part ended.

use std::fs::File;
use std::io;
use std::os::fd::AsFd;
use std::os::unix::net::UnixStream;
use std::path::Path;
use std::sync::mpsc::{Receiver, channel};
use std::time::Duration;

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::process::{Signal, set_parent_process_death_signal};

use super::gauge::Gauge;
use super::own_entry::OwnEntry;
use crate::control::{Control, Frame};
use crate::link::monotonic;
use crate::link::{Clock, Fabric, Launcher, LauncherMessage, LockStep, RealTime, Seal, WakeFutex};
use crate::machine::identity::{self, CellId};
use crate::machine::scheduling::{Lacks, ask, give_back_priority};
use crate::session::{Membership, Private, prefix};
use mrroc_core::cell::{Cell, RunReport};
use mrroc_core::fault::{Fault, ProcessId, Role};
use mrroc_core::link::places::Places;
use mrroc_core::link::{Nanos, News, Preparation, Waiter};

/// How long an EDP may brake after its launcher is gone.
const LAST_BRAKING: Duration = Duration::from_secs(10);

/// How often a robot that paces itself is heard before the cell begins: often enough for one that does so at 1 kHz.
const KEEPING: Duration = Duration::from_micros(500);

/// Stack of the thread that listens to the launcher \[bytes\], kept small because locked memory holds all of it.
const RECEIVE_STACK: usize = 64 << 10;

/// What a frame of the launcher says. An unexpected frame, or the end of the stream, counts as the close of the cell.
fn heard(frame: io::Result<Frame>) -> LauncherMessage {
    match frame {
        Ok(Frame::Resume { now }) => LauncherMessage::Resume(now),
        Ok(Frame::Lost(process)) => LauncherMessage::News(News::Lost(process)),
        Ok(Frame::Abort) => LauncherMessage::News(News::Abort),
        Ok(Frame::Press { number, button }) => LauncherMessage::Press(number, button),
        Ok(_) | Err(_) => LauncherMessage::Close,
    }
}

impl Launcher for Control {
    fn hear(&self) -> LauncherMessage {
        heard(self.receive())
    }

    fn yields(&self, deadline: Nanos, woken: Places) {
        // If the launcher is gone, sending fails, and the next `hear` reports the close of the cell.
        drop(self.send(&Frame::Waits { deadline, woken }));
    }

    fn calls(&self, place: usize, woken: Places) {
        drop(self.send(&Frame::Calls { place: place as u64, woken }));
    }
}

/// Why a process did not take part.
#[derive(Debug, thiserror::Error)]
pub(crate) enum NoPart {
    /// The process was not started by a launcher, or its launcher is gone.
    #[error("{0} is started by the launcher alone\n help: start the cell by --processes")]
    NoLauncher(ProcessId),
    /// The process could not take part, and has told the launcher why.
    #[error("{0}")]
    Told(String),
}

/// How the run of a cell has ended.
pub(crate) type Concluded = Result<RunReport, Fault>;

/// Runs the process `me` of a cell in the session in `folder`, until the cell closes. A plant that is `watched` then
/// receives the result of the run from its launcher, and returns it.
///
/// # Errors
/// [`NoPart`] when the process cannot take part; then no robot has moved.
pub(crate) fn run(
    cell: Cell,
    me: ProcessId,
    folder: &Path,
    watched: bool,
) -> Result<Option<Concluded>, NoPart> {
    let stdin = io::stdin().as_fd().try_clone_to_owned();
    let control = Control::new(UnixStream::from(stdin.map_err(|_| NoPart::NoLauncher(me))?));
    // A program that reads its standard input finds nothing there, instead of what the launcher says.
    let nothing = File::open("/dev/null").and_then(|nothing| Ok(rustix::stdio::dup2_stdin(nothing)?));
    nothing.map_err(|_| NoPart::NoLauncher(me))?;
    // A process with a robot goes on without its launcher until the robot has braked; any other process ends at once,
    // whatever it does.
    if !has_robot(me) {
        let _ = set_parent_process_death_signal(Some(Signal::KILL));
    }
    let gone = |_: io::Error| NoPart::NoLauncher(me);
    let Frame::Welcome { seal, cell: id, clock, spin } = control.receive().map_err(gone)? else {
        return Err(NoPart::NoLauncher(me));
    };
    match take_part((cell, id), me, folder, &control, (seal, clock, spin)) {
        Ok((over, receiver)) => {
            control.send(&over).map_err(gone)?;
            if !watched || me.role != Role::Plant {
                return Ok(None);
            }
            // In real time the receive thread passes the frame on; there is no frame if the launcher is gone.
            let last = receiver.map_or_else(|| control.receive().ok(), |receiver| receiver.recv().ok());
            Ok(last.and_then(concluded))
        }
        Err(Ended::Closed) => Ok(None),
        Err(Ended::Refuses(text)) => {
            drop(control.send(&Frame::Refuses(text.clone())));
            Err(NoPart::Told(text))
        }
    }
}

/// How the run has ended, as the launcher tells it.
fn concluded(frame: Frame) -> Option<Concluded> {
    match frame {
        Frame::Over { steps, time, outcome } => {
            let report = RunReport { steps, time: Duration::from_nanos(time) };
            outcome.map(|outcome| outcome.map(|()| report))
        }
        _ => None,
    }
}

/// What a process sends to the launcher at its end; and, in real time, where its receive thread passes on what the
/// launcher answers.
type LastWords = (Frame, Option<Receiver<Frame>>);

/// Why a process ended before it ran.
enum Ended {
    Refuses(String),
    /// The launcher gave the launch up, or is gone.
    Closed,
}

impl Ended {
    fn of(error: impl core::fmt::Display) -> Ended {
        Ended::Refuses(error.to_string())
    }

    fn for_want_of_a_thread(error: io::Error) -> Ended {
        Ended::Refuses(format!(
            "a thread cannot be started: {error}{}",
            crate::machine::capacity::remedy(&error)
        ))
    }
}

fn take_part(
    (cell, id): (Cell, CellId),
    me: ProcessId,
    folder: &Path,
    control: &Control,
    (seal, clock, spin): (Seal, Clock, Nanos),
) -> Result<LastWords, Ended> {
    let membership = Membership::join(folder).map_err(Ended::of)?;
    let _part = identity::take_part(id).map_err(Ended::of)?;
    if membership.number != seal.session {
        return Err(Ended::Refuses("its launcher is of another session".to_owned()));
    }
    let (realtime, step) = (cell.realtime().cloned(), cell.step_length().as_nanos() as Nanos);
    let mut fabric = Fabric::new(me, clock);
    let entry = OwnEntry::default();
    let cell = match me.role {
        Role::Edp => cell.watch(entry.of_robot()),
        Role::Plant => {
            let bodies = entry.of_bodies(&cell.layout().bodies);
            cell.observed_by(bodies)
        }
        Role::Mp | Role::Ecp | Role::Vsp | Role::Node => cell,
    };
    let assembly = cell.put_on(&mut fabric).map_err(Ended::of)?;
    let Some(body) = fabric.take_body() else {
        return Err(Ended::Refuses("the cell has no such process".to_owned()));
    };
    let private = Private::begin();
    fabric.create(folder, &prefix(seal.session), seal).map_err(Ended::of)?;
    drop(private);
    say(control, &Frame::Created { fingerprint: fabric.fingerprint() })?;
    let Ok(Frame::Connect) = control.receive() else { return Err(Ended::Closed) };
    entry.open(&fabric, me, seal).map_err(Ended::of)?;
    fabric.connect(seal).map_err(Ended::of)?;
    // The gauge's thread starts before this thread asks for its priority: a new thread would inherit it.
    let gauge = match clock {
        Clock::Real => Some(Gauge::start(control, step).map_err(Ended::for_want_of_a_thread)?),
        Clock::Virtual => None,
    };
    let lacks = match (clock, realtime) {
        (Clock::Real, Some(realtime)) => {
            let ecps: Vec<_> = fabric.places().iter().filter(|id| id.role == Role::Ecp).copied().collect();
            ask(&realtime, me, &ecps)
        }
        (Clock::Real, None) | (Clock::Virtual, _) => Lacks::default(),
    };
    // After that: the threads that drivers receive with are as urgent as what waits for what they receive.
    let preparation = fabric.take_preparation();
    preparation.iter().for_each(|preparation| preparation.open());
    say(control, &Frame::Ready { lacks })?;
    if let (Some(preparation), Clock::Real) = (&preparation, clock) {
        keep_until_a_frame_comes(control, &**preparation);
    }
    let Ok(Frame::Go { origin }) = control.receive() else { return Err(Ended::Closed) };
    let (time, receiver) = match (gauge, fabric.wake_futex()) {
        (Some(gauge), Some(wake_futex)) => {
            let (heard, receiver) =
                listen(control, wake_futex, has_robot(me)).map_err(Ended::for_want_of_a_thread)?;
            let waiter = RealTime::new(wake_futex, heard, (origin, spin), gauge.samples())
                .showing(entry.of(me), entry.stops(me))
                .supervised_by(entry.supervised(me))
                .slewed_by(entry.slew());
            if let Some(preparation) = preparation {
                keep_until(origin, &*preparation);
            }
            body(waiter.host());
            // To let go of a link takes tens of milliseconds, in which robots of other processes may still be braking on this core.
            give_back_priority();
            gauge.end();
            (waiter.now(), Some(receiver))
        }
        _ => {
            let waiter = LockStep::new(control, fabric.woken(), entry.of(me), entry.stops(me));
            body(waiter.host());
            (waiter.now(), None)
        }
    };
    for rest in assembly.rests.borrow().iter() {
        say(control, &Frame::Rested(*rest))?;
    }
    let outcome = assembly.outcomes.borrow().iter().find(|(process, _)| *process == me).cloned();
    let outcome = outcome.map(|(_, outcome)| outcome);
    Ok((Frame::Over { steps: assembly.steps.get(), time, outcome }, receiver))
}

/// Keeps connected what was opened while other processes still open theirs.
fn keep_until_a_frame_comes(control: &Control, preparation: &dyn Preparation) {
    let nap = Timespec::try_from(KEEPING).ok();
    loop {
        let mut frame = [PollFd::from_borrowed_fd(control.descriptor(), PollFlags::IN)];
        // A wait that a signal has interrupted is over, too.
        if poll(&mut frame, nap.as_ref()).is_ok_and(|frames| frames > 0) {
            return;
        }
        preparation.keep();
    }
}

/// The same until the cell's time begins, at `origin` of the machine's monotonic clock \[ns\].
fn keep_until(origin: Nanos, preparation: &dyn Preparation) {
    while monotonic() + (KEEPING.as_nanos() as Nanos) < origin {
        std::thread::sleep(KEEPING);
        preparation.keep();
    }
}

/// Whether robots are braked by this process.
fn has_robot(me: ProcessId) -> bool {
    matches!(me.role, Role::Edp | Role::Plant)
}

fn say(control: &Control, frame: &Frame) -> Result<(), Ended> {
    control.send(frame).map_err(|_| Ended::Closed)
}

/// Receives the launcher's frames in a thread of its own, which wakes the process, so that a step waits in one place
/// only. When the launcher is gone, a process with a robot brakes it and ends; if its drives do not return in that
/// time, the thread ends the process. The first receiver gets what concerns the running cell, the second one the result
/// of the run.
fn listen(
    control: &Control,
    wake_futex: WakeFutex,
    has_robot: bool,
) -> io::Result<(Receiver<LauncherMessage>, Receiver<Frame>)> {
    let control = control.try_clone()?;
    control.wait_for_ever()?;
    let (tells, hears) = channel();
    let (concludes, concluded) = channel();
    std::thread::Builder::new().name("receive".to_owned()).stack_size(RECEIVE_STACK).spawn(move || {
        loop {
            let frame = match control.receive() {
                Ok(over @ Frame::Over { .. }) => {
                    let _ = concludes.send(over);
                    continue;
                }
                frame => frame,
            };
            let gone = frame.is_err();
            // Sending fails only when the process has stopped listening, which means that it is about to end.
            let _ = tells.send(heard(frame));
            wake_futex.wake();
            if gone {
                break;
            }
        }
        drop(concludes);
        if has_robot {
            std::thread::sleep(LAST_BRAKING);
            std::process::exit(1);
        }
    })?;
    Ok((hears, concluded))
}
