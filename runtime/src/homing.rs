//! The EDP of a robot that does not know where it is: it looks for its reference marks until it does.
//!
//! In: queries, which it answers with [`flag::HOMING`] and no image. Out: the drives of a robot that an
//! [`Edp`](crate::edp::Edp) can move. A demand cannot be accepted here: there is nothing to check it against.

use core::time::Duration;

use crate::driver::{DriveFault, Driver, Homing, Search};
use crate::edp::guarded;
use crate::fault::{Fault, FaultKind, ProcessId};
use crate::link::{Nanos, Server, Waiter};
use crate::message::{Kind, Message, RequestKind, flag};
use crate::robot::Robot;

/// The drives that a robot is set up with.
pub(crate) enum Drives<R: Robot> {
    /// They know where it is.
    Homed(Box<dyn Driver<R>>),
    /// They do not.
    Unhomed(Box<dyn AnyHoming<R>>),
}

impl<R: Robot> Drives<R> {
    pub fn period(&self) -> Duration {
        match self {
            Drives::Homed(driver) => driver.period(),
            Drives::Unhomed(homing) => homing.period(),
        }
    }
}

/// A search of any kind.
pub(crate) trait AnyHoming<R: Robot> {
    fn period(&self) -> Duration;

    /// One servo period; the drives when it is over.
    fn search(&mut self) -> Result<Option<Box<dyn Driver<R>>>, DriveFault>;
}

/// The search itself, until it is over.
impl<R: Robot, H: Homing<R, Drives: 'static>> AnyHoming<R> for Option<H> {
    fn period(&self) -> Duration {
        self.as_ref().map_or(Duration::ZERO, Homing::period)
    }

    fn search(&mut self) -> Result<Option<Box<dyn Driver<R>>>, DriveFault> {
        match self.take().map(Homing::search).transpose()? {
            Some(Search::Found(drives)) => Ok(Some(Box::new(drives))),
            Some(Search::Searching(search)) => {
                *self = Some(search);
                Ok(None)
            }
            None => Ok(None),
        }
    }
}

/// Searches and answers until the marks are found; `None` when the cell closes before.
pub(crate) fn home<R: Robot>(
    process: ProcessId,
    waiter: &dyn Waiter,
    port: &dyn Server,
    mut homing: Box<dyn AnyHoming<R>>,
) -> Option<Box<dyn Driver<R>>> {
    let servo = homing.period().as_nanos() as Nanos;
    let mut next_tick = waiter.now() + servo / 2;
    let (mut request, mut fault, mut stopped) = (Message::empty(), None, false);
    loop {
        waiter.wait(Some(next_tick)).ok()?;
        while port.receive(&mut request) {
            stopped |= request.header.kind == Kind::Request(RequestKind::Stop);
            if !matches!(request.header.kind, Kind::Request(RequestKind::Query | RequestKind::Stop)) {
                fault.get_or_insert(Fault::new(FaultKind::Message).in_process(process));
            }
            port.reply(&answer(&request, fault.as_ref(), stopped));
        }
        while waiter.now() >= next_tick {
            // What is searched no more comes to rest by itself.
            if !stopped && fault.is_none() {
                match guarded(|| homing.search()) {
                    Ok(Ok(Some(driver))) => return Some(driver),
                    Ok(Ok(None)) => {}
                    Ok(Err(trip)) => fault = Some(Fault::of_drive(&trip).in_process(process)),
                    Err(panic) => fault = Some(panic.in_process(process)),
                }
            }
            next_tick += servo;
        }
    }
}

fn answer(request: &Message, fault: Option<&Fault>, stopped: bool) -> Message {
    let mut reply = Message::new(Kind::Reply);
    (reply.header.step, reply.header.instruction) = (request.header.step, request.header.instruction);
    reply.header.flags = if stopped || fault.is_some() { flag::STANDSTILL } else { flag::HOMING };
    if let Some(fault) = fault {
        reply.set_fault(fault);
    }
    reply
}
