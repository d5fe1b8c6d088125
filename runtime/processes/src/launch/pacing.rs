//! A cell in lock-step under the virtual clock: the memory link's scheduler resumes processes in place of coroutines.
//!
//! In: processes that are ready to run, and buttons that consoles press. Out: how the run ended. Each process has a proxy in the
//! launcher's scheduler, which resumes the process over its socket. What consoles press reaches an MP when it is resumed the next
//! time: a run without consoles is the same to the bit, and one with consoles is as if the operator had acted in those steps.

use core::cell::RefCell;
use std::rc::Rc;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use super::ABORTING;
use super::ending::{Run, note};
use super::process_set::{Member, Over, ProcessSet};
use crate::consoles::ConsoleServer;
use crate::control::Frame;
use crate::machine::signals::Signals;
use mrroc_core::cell::CellError;
use mrroc_core::fault::{Fault, ProcessId, Role};
use mrroc_core::link::memory::Scheduler;
use mrroc_core::link::places::Places;
use mrroc_core::link::{Link, Nanos, Waiter};

/// Runs a cell in lock-step under the virtual clock: the memory link's scheduler resumes processes in place of
/// coroutines, one at a time and in the same order, so that the run is the same as on the memory link.
pub(super) fn pace(
    process_set: &ProcessSet,
    signals: &Signals,
    console_server: ConsoleServer,
    stop: Duration,
) -> Result<Run, CellError> {
    process_set.go(0);
    let consoles = Rc::new(Consoles { server: console_server, pressed: RefCell::default() });
    let mut scheduler = Scheduler::new();
    let places: Vec<_> = process_set.members.iter().map(|member| scheduler.place(member.id)).collect();
    let death = Rc::new(RefCell::new(None));
    for (member, place) in process_set.members.iter().zip(places) {
        let proxy = Proxy {
            member: Rc::clone(member),
            wake: scheduler.waker(),
            close: scheduler.closer(),
            ends: signals.ends_flag(),
            death: Rc::clone(&death),
            consoles: Rc::clone(&consoles),
            stop: stop.as_nanos() as Nanos,
            all: process_set.members.clone(),
            place,
        };
        scheduler.body(place, Box::new(move |host| proxy.run(host.waiter)))?;
    }
    let time = scheduler.run()?;
    let death = death.take();
    Ok(Run::of(process_set, death, Some(time)))
}

/// The consoles of the cell.
struct Consoles {
    server: ConsoleServer,
    /// What was pressed, and has not been given to its MP yet.
    pressed: RefCell<Vec<(ProcessId, Frame)>>,
}

impl Consoles {
    /// Takes what was pressed for an MP.
    fn take(&self, mp: ProcessId) -> Vec<Frame> {
        let mut pressed = self.pressed.borrow_mut();
        pressed.extend(self.server.presses());
        pressed.extract_if(.., |(of, _)| *of == mp).map(|(_, press)| press).collect()
    }
}

/// Represents a process in the scheduler of the launcher.
struct Proxy {
    member: Rc<Member>,
    wake: Box<dyn Fn(Places)>,
    close: Box<dyn Fn()>,
    /// Whether a signal has asked the launcher to end.
    ends: Arc<AtomicBool>,
    death: Rc<RefCell<Option<Fault>>>,
    consoles: Rc<Consoles>,
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
        // Until when the MP's program has to end after an abort.
        let mut aborting = None;
        loop {
            if self.member.id.role == Role::Mp {
                // If the process is gone, the next frame finds that out.
                self.consoles
                    .take(self.member.id)
                    .iter()
                    .for_each(|press| drop(self.member.control.send(press)));
            }
            let mut answered = self.member.control.send(&frame).and_then(|()| self.member.control.receive());
            while let Ok(Frame::Rested(rest)) = answered {
                self.member.rests.borrow_mut().push(rest);
                answered = self.member.control.receive();
            }
            match answered {
                Ok(Frame::Waits { deadline, woken }) => {
                    (self.wake)(woken);
                    if mp && self.ends.load(Ordering::Acquire) {
                        self.abort(&mut aborting, waiter.now());
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
                    self.consoles.server.ended(self.member.id);
                    if mp {
                        (self.close)();
                    }
                    return;
                }
                Ok(_) | Err(_) => return self.mourn(waiter, mp),
            }
        }
    }

    /// Tells the MP to abort, once, and closes the cell if its program goes on although it was aborted.
    fn abort(&self, until: &mut Option<Nanos>, now: Nanos) {
        match *until {
            None => {
                // If the process is gone, the next frame finds that out.
                drop(self.member.control.send(&Frame::Abort));
                *until = Some(now + self.stop + ABORTING.as_nanos() as Nanos);
            }
            Some(until) if now >= until => (self.close)(),
            Some(_) => {}
        }
    }

    /// Lets the process at a place run until it waits, as if it were a part of the calling process.
    fn call(&self, place: u64, now: Nanos) {
        let Ok(place) = usize::try_from(place) else { return };
        let Some(called) = self.all.get(place) else { return };
        if called.gone.get() || called.over.borrow().is_some() {
            return;
        }
        match called.control.send(&Frame::Resume { now }).and_then(|()| called.control.receive()) {
            // The calling process goes on at once, so it needs no wake-up.
            Ok(Frame::Waits { woken, .. }) => (self.wake)(woken.without(self.place)),
            // The called process is gone: its own proxy notices that when it is resumed.
            Ok(_) | Err(_) => (self.wake)(Places::of(place)),
        }
    }

    /// Reports the death of the process. When the MP has died, the robots stop by themselves, and then the cell closes.
    fn mourn(&self, waiter: &dyn Waiter, mp: bool) {
        let how = self.member.reap();
        self.consoles.server.ended(self.member.id);
        // Who has to do with a sensor or a lower cell notices the loss.
        if self.member.id.role == Role::Vsp || self.member.id.is_of_lower_cell() {
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
