//! The EDP of a robot that does not know where it is: it looks for its reference marks until it does.
//!
//! In: queries, which it answers with [`flag::HOMING`] and no image. Out: the drives of a robot that an
//! [`Edp`](crate::control::edp::Edp) can move. A demand cannot be accepted here: there is nothing to check it against.

use core::marker::PhantomData;
use core::time::Duration;

use crate::control::guarded::guarded;
use crate::link::message::{Kind, Message, RequestKind, flag};
use crate::link::{Server, Waiter};
use crate::model::any_kind::{AnyKind, DrivesOf};
use crate::model::drive_fault::DriveFault;
use crate::model::driver::{Driver, Homing, Search};
use crate::model::fault::{Fault, FaultKind, ProcessId};
use crate::model::pace::{Pace, ServoPeriod};
use crate::model::robot::Robot;
use crate::model::time::Nanos;
use crate::safety::latch::{Admission, Gate, GateRequest};

/// The drives that a robot is set up with.
pub(crate) enum Drives<R: Robot> {
    /// They know where it is.
    Homed(Box<dyn Driver<R>>),
    /// They do not.
    Unhomed(Box<dyn AnyHoming<R>>),
}

impl<R: Robot> Drives<R> {
    pub fn period(&self) -> Duration {
        self.servo_period().length
    }

    pub fn servo_period(&self) -> ServoPeriod {
        match self {
            Drives::Homed(driver) => ServoPeriod { length: driver.period(), pace: driver.pace() },
            Drives::Unhomed(homing) => homing.period().into(),
        }
    }

    /// What the drives are, for the whole machine.
    pub fn hardware(&self) -> Option<String> {
        match self {
            Drives::Homed(driver) => driver.hardware(),
            Drives::Unhomed(homing) => homing.hardware(),
        }
    }
}

/// A search of any kind.
pub(crate) trait AnyHoming<R: Robot> {
    fn period(&self) -> Duration;

    /// What the drives are, for the whole machine.
    fn hardware(&self) -> Option<String> {
        None
    }

    /// One servo period; the drives when it is over.
    fn search(&mut self) -> Result<Option<Box<dyn Driver<R>>>, DriveFault>;
}

/// The search of drives of one kind of robots, until it is over.
pub(crate) struct HomingOf<R, H>(Option<H>, PhantomData<fn() -> R>);

impl<R: Robot, H: Homing<R>> HomingOf<R, H> {
    pub const fn new(homing: H) -> Self {
        HomingOf(Some(homing), PhantomData)
    }
}

impl<R: Robot, H: Homing<R, Drives: 'static>> AnyHoming<AnyKind<R::Joints>> for HomingOf<R, H> {
    fn period(&self) -> Duration {
        self.0.as_ref().map_or(Duration::ZERO, Homing::period)
    }

    fn hardware(&self) -> Option<String> {
        self.0.as_ref().and_then(Homing::hardware)
    }

    fn search(&mut self) -> Result<Option<Box<dyn Driver<AnyKind<R::Joints>>>>, DriveFault> {
        match self.0.take().map(Homing::search).transpose()? {
            Some(Search::Found(drives)) => Ok(Some(Box::new(DrivesOf::new(drives)))),
            Some(Search::Searching(search)) => {
                self.0 = Some(search);
                Ok(None)
            }
            None => Ok(None),
        }
    }
}

/// Searches and answers until the marks are found: the drives, and the gate of the process that has them. `None` when the
/// cell closes before.
pub(crate) fn home<R: Robot>(
    process: ProcessId,
    waiter: &dyn Waiter,
    port: &dyn Server,
    mut homing: Box<dyn AnyHoming<R>>,
) -> Option<(Box<dyn Driver<R>>, Gate)> {
    let period = homing.period();
    let servo = period.as_nanos() as Nanos;
    let mut next_tick = waiter.now() + servo / 2;
    let mut request = Message::empty();
    let mut state = State::Searching;
    let mut suspended = false;
    let mut gate = Gate::default();
    loop {
        waiter.wait(Some(next_tick)).ok()?;
        while port.receive(&mut request) {
            let (next, admission) = gate.meet(request.header.epoch, asked(&request), !state.searches());
            gate = next;
            match request.header.kind {
                _ if admission == Admission::Ignored => continue,
                Kind::Request(RequestKind::Query) => suspended = request.is(flag::SUSPENDED),
                Kind::Request(RequestKind::Stop) => state.end(None),
                // The search goes on where it was. One that has failed has nothing left to search with.
                Kind::Request(RequestKind::Reset) if admission == Admission::Done => state.resume(),
                _ => state.end(Some(Fault::new(FaultKind::Message).in_process(process))),
            }
            port.reply(&answer(&request, &state));
        }
        while waiter.now() >= next_tick {
            match &mut state {
                // Drives whose search has ended come to rest by themselves, within a period.
                State::Ended { rests, .. } => *rests = true,
                State::Searching if suspended => {}
                State::Searching => match guarded(|| homing.search()) {
                    Ok(Ok(None)) => {}
                    Ok(Ok(Some(driver))) if driver.period() == period && driver.pace() == Pace::Cell => {
                        return Some((driver, gate));
                    }
                    Ok(Ok(Some(_))) => {
                        let text =
                            "the drives that homing found have another servo period or pace than homing";
                        state.end(Some(Fault::thrown(text).in_process(process)));
                    }
                    Ok(Err(trip)) => state.end(Some(Fault::of_drive(&trip).in_process(process))),
                    Err(panic) => state.end(Some(panic.in_process(process))),
                },
            }
            next_tick += servo;
        }
    }
}

/// How far the search is.
enum State {
    Searching,
    /// Stopped, or given up for a fault; and whether the drives have had the time to come to rest.
    Ended {
        fault: Option<Fault>,
        rests: bool,
    },
}

impl State {
    const fn searches(&self) -> bool {
        matches!(self, State::Searching)
    }

    /// A reset: what was only stopped goes on.
    fn resume(&mut self) {
        if let State::Ended { fault: None, .. } = self {
            *self = State::Searching;
        }
    }

    /// The first fault is kept.
    fn end(&mut self, fault: Option<Fault>) {
        match self {
            State::Searching => *self = State::Ended { fault, rests: false },
            State::Ended { fault: first, .. } => *first = first.take().or(fault),
        }
    }
}

/// What a request asks, as far as the gate is concerned: no demand is taken here.
const fn asked(request: &Message) -> GateRequest {
    match request.header.kind {
        Kind::Request(RequestKind::Stop) => GateRequest::Stop,
        Kind::Request(RequestKind::Reset) => GateRequest::Reset,
        _ => GateRequest::Look,
    }
}

fn answer(request: &Message, state: &State) -> Message {
    let mut reply = Message::new(Kind::Reply);
    reply.header.epoch = request.header.epoch;
    reply.header.step = request.header.step;
    reply.header.instruction = request.header.instruction;
    match state {
        State::Searching => reply.header.flags = flag::HOMING,
        State::Ended { fault, rests } => {
            reply.header.flags = if *rests { flag::STANDSTILL } else { 0 };
            if let Some(fault) = fault {
                reply.set_fault(fault);
            }
        }
    }
    reply
}
