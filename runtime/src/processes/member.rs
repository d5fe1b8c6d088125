//! One process of a cell: joins the session that its launcher made, runs its part, and says how it ended.

#![expect(clippy::disallowed_methods, reason = "the process has lost its cell, and its clock with it")]

use std::io;
use std::os::fd::{AsFd, BorrowedFd};
use std::os::unix::net::UnixStream;
use std::path::Path;
use std::time::Duration;

use rustix::event::{PollFd, PollFlags, poll};
use rustix::process::{Signal, set_parent_process_death_signal};

use super::control::{Control, Frame};
use super::scheduling::{Lacks, ask};
use super::session::{Membership, prefix};
use crate::cell::Cell;
use crate::fault::{ProcessId, Role};
use crate::link::iceoryx::{Clock, Fabric, Heard, Launcher, LockStep, RealTime, Seal};
use crate::link::{Nanos, News, Waiter};

/// How long an EDP may brake after its launcher is gone.
const LAST_BRAKING: Duration = Duration::from_secs(10);

impl Launcher for Control {
    fn descriptor(&self) -> BorrowedFd<'_> {
        Control::descriptor(self)
    }

    fn hear(&self) -> Heard {
        match self.receive() {
            Ok(Frame::Resume { now }) => Heard::Resume(now),
            Ok(Frame::Lost(process)) => Heard::News(News::Lost(process)),
            Ok(Frame::Abort) => Heard::News(News::Abort),
            // A launcher that says anything else is none, and one that is gone says nothing more.
            Ok(_) | Err(_) => Heard::Close,
        }
    }

    fn yields(&self, deadline: Nanos, woken: u64) {
        // A launcher that is gone resumes nobody: `hear` tells.
        drop(self.send(&Frame::Waits { deadline, woken }));
    }
}

/// Why a process did not take part.
#[derive(Debug, thiserror::Error)]
pub(crate) enum NoPart {
    /// It was not started by a launcher, or its launcher is gone.
    #[error("{0} is started by the launcher alone\n help: start the cell by --processes")]
    NoLauncher(ProcessId),
    /// The launcher has been told why.
    #[error("{0}")]
    Told(String),
}

/// Runs the process `me` of a cell in the session in `folder`, until the cell closes.
///
/// # Errors
/// [`NoPart`] when it cannot take part; then nothing has moved.
pub(crate) fn run(cell: Cell, me: ProcessId, folder: &Path) -> Result<(), NoPart> {
    let stdin = io::stdin().as_fd().try_clone_to_owned();
    let control = Control::new(UnixStream::from(stdin.map_err(|_| NoPart::NoLauncher(me))?));
    // A robot outlives its launcher for as long as it brakes; what has no robot goes at once, whatever it does.
    if me.role != Role::Edp {
        let _ = set_parent_process_death_signal(Some(Signal::KILL));
    }
    let gone = |_: io::Error| NoPart::NoLauncher(me);
    let Frame::Welcome { seal, clock, spin } = control.receive().map_err(gone)? else {
        return Err(NoPart::NoLauncher(me));
    };
    match take_part(cell, me, folder, &control, (seal, clock, spin)) {
        Ok(over) => control.send(&over).map_err(gone),
        Err(Ended::Closed) => Ok(()),
        Err(Ended::Refuses(text)) => {
            drop(control.send(&Frame::Refuses(text.clone())));
            Err(NoPart::Told(text))
        }
    }
}

/// Why a process ended before it ran.
enum Ended {
    Refuses(String),
    /// The launcher gave up, or is gone.
    Closed,
}

impl Ended {
    fn of(error: impl core::fmt::Display) -> Ended {
        Ended::Refuses(error.to_string())
    }
}

fn take_part(
    cell: Cell,
    me: ProcessId,
    folder: &Path,
    control: &Control,
    (seal, clock, spin): (Seal, Clock, Nanos),
) -> Result<Frame, Ended> {
    let membership = Membership::join(folder).map_err(Ended::of)?;
    if membership.number != seal.session {
        return Err(Ended::Refuses("its launcher is of another session".to_owned()));
    }
    let realtime = cell.realtime().cloned();
    let mut fabric = Fabric::new(me);
    let assembly = cell.put_on(&mut fabric).map_err(Ended::of)?;
    let Some(body) = fabric.take_body() else {
        return Err(Ended::Refuses("the cell has no such process".to_owned()));
    };
    fabric.create(folder, &prefix(seal.session), seal, clock).map_err(Ended::of)?;
    say(control, &Frame::Created { fingerprint: fabric.fingerprint() })?;
    let Ok(Frame::Connect) = control.receive() else { return Err(Ended::Closed) };
    fabric.connect(seal, clock).map_err(Ended::of)?;
    let lacks = match (clock, realtime) {
        (Clock::Real, Some(realtime)) => {
            let ecps: Vec<_> = fabric.places().iter().filter(|id| id.role == Role::Ecp).copied().collect();
            ask(&realtime, me, &ecps)
        }
        (Clock::Real, None) | (Clock::Virtual, _) => Lacks::default(),
    };
    say(control, &Frame::Ready { lacks })?;
    let Ok(Frame::Go { origin }) = control.receive() else { return Err(Ended::Closed) };
    let time = match (clock, fabric.take_listener()) {
        (Clock::Real, Some(listener)) => {
            if me.role == Role::Edp {
                end_after_launcher(control).map_err(Ended::of)?;
            }
            let waiter = RealTime::new(listener, control, origin, spin);
            body(&waiter);
            waiter.now()
        }
        (Clock::Virtual, _) | (Clock::Real, None) => {
            let waiter = LockStep::new(control, fabric.woken());
            body(&waiter);
            waiter.now()
        }
    };
    let outcome = assembly.outcomes.borrow().iter().find(|(process, _)| *process == me).cloned();
    Ok(Frame::Over { steps: assembly.steps.get(), time, outcome: outcome.map(|(_, outcome)| outcome) })
}

fn say(control: &Control, frame: &Frame) -> Result<(), Ended> {
    control.send(frame).map_err(|_| Ended::Closed)
}

/// An EDP whose launcher is gone brakes its robot and ends. One whose drives do not return is ended.
fn end_after_launcher(control: &Control) -> io::Result<()> {
    let descriptor = control.descriptor().try_clone_to_owned()?;
    std::thread::Builder::new().name("guard".to_owned()).spawn(move || {
        loop {
            // The end of the stream, and nothing else: frames are the process's to read.
            let mut end = [PollFd::new(&descriptor, PollFlags::RDHUP)];
            let polled = poll(&mut end, None);
            if polled.is_ok()
                && end[0].revents().intersects(PollFlags::RDHUP | PollFlags::HUP | PollFlags::ERR)
            {
                break;
            }
        }
        std::thread::sleep(LAST_BRAKING);
        std::process::exit(1);
    })?;
    Ok(())
}
