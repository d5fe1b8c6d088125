//! The protocol of a gripper: which registers are written and read when, and what its status means.
//!
//! First the status is read until the fingers stand, after an activation where that is asked for; then what is demanded is written, and
//! the status read, at most 200 times a second. One question is asked at a time.

use core::sync::atomic::{AtomicU8, AtomicU64, Ordering};
use core::time::Duration;
use std::sync::Arc;

use mrroc::robot::{DriveFault, RobotStop, StopCause};
use mrroc_driver_kit::{NotConnected, Number, Protocol, Received, Speed, Times};
use mrroc_modbus::client::{Broken, Client, lost};
use mrroc_modbus::message::{Answer, NoAnswer, Table, UnitRequest};

use crate::registers::{Fingers, REQUEST, Request, STATUS, Status};
use crate::settings::RobotiqSettings;

/// The shortest time from one exchange to the next: a gripper takes 200 a second at most.
const PAUSE: Duration = Duration::from_millis(5);

/// How long the fingers may go on moving by what somebody else has told them, when the drives are opened.
const SETTLING: Duration = Duration::from_secs(6);

/// How long the gripper may take to become inactive, and to activate itself.
const RESET: Duration = Duration::from_secs(1);
const ACTIVATION: Duration = Duration::from_secs(20);

/// Exchanges after which a position that was told must have arrived.
const ECHOES: u32 = 100;

/// The fastest that fingers go: demands, not this, say how fast they are.
const SPEED: u8 = 255;

/// How far it has come.
#[derive(Clone, Copy, Debug)]
enum Phase {
    /// Asks for the status until it is as it should be.
    Status(Awaited),
    /// Waits until an activation is asked for.
    Unasked,
    /// Writes a request, and goes on with that.
    Write(Request, Written),
    /// Writes what is demanded, or nothing where that holds the fingers already, and reads.
    Follow {
        /// Where the fingers were held at the beginning.
        held: u8,
        /// Exchanges in a row in which what was told had not arrived.
        unheard: u32,
        /// What the present exchange is about, when it has begun.
        round: Option<Round>,
    },
}

/// A status that is waited for, and until when.
#[derive(Clone, Copy, Debug)]
enum Awaited {
    /// The first one: whatever it is.
    First,
    /// That it is reset.
    Reset(Duration),
    /// That it is active.
    Active(Duration),
    /// The one after the activation: whatever it is.
    Activated,
    /// That it has been told something.
    Told(Duration),
    /// That the fingers stand.
    Standing(Duration),
}

/// What follows a request that was written.
#[derive(Clone, Copy, Debug)]
enum Written {
    /// It becomes inactive.
    Resets,
    /// It activates itself.
    Activates,
    /// It is inactive again, until it is asked for.
    Waits,
    /// It is inactive again: its activation has taken too long.
    Ends,
}

/// An exchange: what was demanded when it began.
#[derive(Clone, Copy, Debug)]
struct Round {
    /// `None` where nothing is to be written, or was written.
    write: Option<Request>,
    position: u8,
    /// Whether this was not the last that was told.
    is_news: bool,
    is_held: bool,
}

/// Whether the gripper may be activated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Inactive {
    /// One that is not active is refused.
    Refused,
    /// One that is not active is activated, while that is asked for.
    Activated,
}

/// What the exchange and the drives hand to each other.
#[derive(Debug, Default)]
pub(crate) struct Shared {
    times: Times,
    /// Where the fingers are held, or were told to go last, and the force from the next motion on, in the gripper's numbers.
    pub position: AtomicU8,
    pub force: AtomicU8,
    /// The newest status; the speed in the gripper's numbers a second, positive while they close.
    status: AtomicU64,
    pub speed: Number,
}

impl AsRef<Times> for Shared {
    fn as_ref(&self) -> &Times {
        &self.times
    }
}

impl Shared {
    /// The newest status; `None` before the fingers are known to stand.
    pub fn status(&self) -> Option<Status> {
        Status::from_word(self.status.load(Ordering::Relaxed))
    }
}

/// The protocol, and what is known of the gripper.
pub(crate) struct GripperProtocol {
    shared: Arc<Shared>,
    client: Client,
    /// For how long a device that is only busy is asked again: an exchange is two questions.
    timeout: Duration,
    inactive: Inactive,
    phase: Phase,
    /// Nothing is asked before.
    next: Duration,
    /// Until when a device that is only busy is asked again for its status.
    asked_until: Option<Duration>,
    /// What was written last.
    told: Option<Request>,
    speed: Speed,
}

impl Protocol for GripperProtocol {
    type Fault = DriveFault;

    fn poll(
        &mut self,
        now: Duration,
        received: Received<'_>,
        send: &mut Vec<u8>,
    ) -> Result<Duration, DriveFault> {
        self.client.receive(&received);
        loop {
            match self.client.answer(now) {
                Ok(Some(answer)) => self.take(now, &answer)?,
                Ok(None) => {}
                Err(Broken::NoAnswer(why)) if why.passes() => self.ask_again(now, why)?,
                Err(broken) => return Err(broken.into()),
            }
            if let Some(until) = self.client.until() {
                return Ok(until);
            }
            let next = self.next.max(self.client.may_ask_from());
            if now < next {
                return Ok(next);
            }
            self.ask(now, send);
        }
    }

    fn not_connected(&self, _: NotConnected) -> DriveFault {
        Broken::Unreachable.into()
    }
}

impl GripperProtocol {
    pub(crate) fn new(
        shared: Arc<Shared>,
        settings: &RobotiqSettings,
        inactive: Inactive,
    ) -> GripperProtocol {
        GripperProtocol {
            shared,
            client: Client::new(settings.unit, settings.timeout),
            timeout: settings.timeout * 2,
            inactive,
            phase: Phase::Status(Awaited::First),
            next: Duration::ZERO,
            asked_until: None,
            told: None,
            speed: Speed::from(Duration::ZERO, 0.0),
        }
    }

    fn pause(&mut self, now: Duration) {
        self.next = now + PAUSE;
    }

    /// The next question of the phase.
    fn ask(&mut self, now: Duration, send: &mut Vec<u8>) {
        const READ: UnitRequest = UnitRequest::Read(Table::InputRegisters, STATUS, 3);
        let write = |request: Request| UnitRequest::Write(REQUEST, request.registers());
        let what = match &mut self.phase {
            Phase::Status(_) => {
                self.asked_until.get_or_insert(now + self.timeout);
                READ
            }
            // Faults are cleared, and an activation begins, where the request to be active rises.
            Phase::Unasked if self.shared.times.is_asked(now) => {
                self.phase = Phase::Write(Request::Rest, Written::Resets);
                write(Request::Rest)
            }
            Phase::Unasked => return self.pause(now),
            Phase::Write(request, _) => write(*request),
            Phase::Follow { held, round, .. } => {
                let round = round.get_or_insert_with(|| {
                    let position = self.shared.position.load(Ordering::Relaxed);
                    let force = self.shared.force.load(Ordering::Relaxed);
                    let request = Request::GoTo { position, speed: SPEED, force };
                    let is_news = self.told != Some(request);
                    // What somebody has closed with another force keeps it until it is moved.
                    let is_held = position == *held && !matches!(self.told, Some(Request::GoTo { .. }));
                    Round { write: (!is_held).then_some(request), position, is_news, is_held }
                });
                round.write.map_or(READ, write)
            }
        };
        self.client.ask(now, what, send);
    }

    /// A device that is only busy is asked again after a while.
    fn ask_again(&mut self, now: Duration, why: NoAnswer) -> Result<(), DriveFault> {
        match &mut self.phase {
            Phase::Status(_) if self.asked_until.is_some_and(|until| now < until) => {}
            // The drives see how old the newest reading is.
            Phase::Follow { round, .. } => {
                if self.shared.times.is_silent_for(now, self.timeout) {
                    return Err(lost(why.name()));
                }
                *round = None;
                self.next_round(now);
                return Ok(());
            }
            Phase::Status(_) | Phase::Unasked | Phase::Write(..) => return Err(Broken::NoAnswer(why).into()),
        }
        self.pause(now);
        Ok(())
    }

    /// The next exchange begins when this one's time is over.
    fn next_round(&mut self, now: Duration) {
        self.next = (self.next + PAUSE).max(now);
    }

    /// The answer to what was asked.
    fn take(&mut self, now: Duration, answer: &Answer) -> Result<(), DriveFault> {
        match self.phase {
            Phase::Status(awaited) => {
                self.asked_until = None;
                self.look(now, awaited, status(answer)?)
            }
            Phase::Write(request, written) => {
                self.told = Some(request);
                self.phase = match written {
                    Written::Resets => Phase::Status(Awaited::Reset(now + RESET)),
                    Written::Activates => Phase::Status(Awaited::Active(now + ACTIVATION)),
                    Written::Waits => Phase::Unasked,
                    Written::Ends => return Err(NOT_ACTIVATED),
                };
                Ok(())
            }
            Phase::Follow { held, unheard, round: Some(round) } => {
                if let Some(request) = round.write {
                    self.told = Some(request);
                    let round = Some(Round { write: None, ..round });
                    self.phase = Phase::Follow { held, unheard, round };
                    return Ok(());
                }
                let status = status(answer)?;
                healthy(status)?;
                let is_told =
                    round.is_held || round.is_news || status.told() == round.position && status.goes();
                let unheard = if is_told { 0 } else { unheard + 1 };
                if unheard > ECHOES {
                    return Err(TOLD_BY_OTHERS);
                }
                self.show(now, status);
                self.phase = Phase::Follow { held, unheard, round: None };
                self.next_round(now);
                Ok(())
            }
            // Nothing was asked.
            Phase::Unasked | Phase::Follow { round: None, .. } => Ok(()),
        }
    }

    /// A status that was waited for, or another one.
    fn look(&mut self, now: Duration, awaited: Awaited, status: Status) -> Result<(), DriveFault> {
        match awaited {
            Awaited::First if !status.is_active() && self.inactive == Inactive::Activated => {
                self.phase = Phase::Unasked;
            }
            Awaited::First | Awaited::Activated if status.is_idle() => {
                // It may have been told nothing before, which it calls a fault until it is.
                self.phase = Phase::Status(Awaited::Told(now + RESET));
            }
            Awaited::Told(until) if status.is_idle() => self.wait(now, until, IDLE)?,
            Awaited::First | Awaited::Activated | Awaited::Told(_) => {
                healthy(status)?;
                self.phase = Phase::Status(Awaited::Standing(now + SETTLING));
            }
            Awaited::Reset(_) if status.is_reset() => {
                self.phase = Phase::Write(Request::Activate, Written::Activates);
            }
            Awaited::Reset(until) => self.wait(now, until, NOT_RESET)?,
            Awaited::Active(_) if status.is_active() => self.phase = Phase::Status(Awaited::Activated),
            Awaited::Active(until) => {
                if let Some(stop) = status.stop().filter(|_| status.must_be_activated_anew()) {
                    return Err(stop.into());
                }
                // Where it is not asked for any more, the fingers stop, and begin anew when it is.
                match self.shared.times.is_asked(now) {
                    false => self.phase = Phase::Write(Request::Rest, Written::Waits),
                    true if now > until => self.phase = Phase::Write(Request::Rest, Written::Ends),
                    true => self.pause(now),
                }
            }
            // Where it goes to no position it stands.
            Awaited::Standing(_) if !status.goes() || status.fingers() != Fingers::Moving => {
                self.stand(now, status);
            }
            Awaited::Standing(until) => self.wait(now, until, MOVED_BY_OTHERS)?,
        }
        Ok(())
    }

    /// It is asked again, or has taken too long.
    fn wait(&mut self, now: Duration, until: Duration, otherwise: DriveFault) -> Result<(), DriveFault> {
        self.pause(now);
        if now > until { Err(otherwise) } else { Ok(()) }
    }

    /// The fingers stand where they are held. Nothing was written.
    fn stand(&mut self, now: Duration, status: Status) {
        let held = if status.goes() { status.told() } else { status.position() };
        self.shared.position.store(held, Ordering::Relaxed);
        self.speed = Speed::from(now, status.position().into());
        self.show(now, status);
        self.phase = Phase::Follow { held, unheard: 0, round: None };
        self.next = now;
    }

    fn show(&mut self, now: Duration, status: Status) {
        if let Some(speed) = self.speed.at(now, status.position().into()) {
            self.shared.speed.set(speed);
        }
        self.shared.status.store(status.to_word(), Ordering::Relaxed);
        self.shared.times.hear(now);
    }
}

fn status(answer: &Answer) -> Result<Status, Broken> {
    let &[a, b, c] = answer.registers() else { return Err(NoAnswer::Length.into()) };
    Ok(Status::new([a, b, c]))
}

fn healthy(status: Status) -> Result<(), DriveFault> {
    status.stop().map_or(Ok(()), |stop| Err(stop.into()))
}

pub(crate) const CLOSED: DriveFault = DriveFault::Other("the gripper is not connected");
const IDLE: DriveFault = lost("fault 9: it was told nothing for a second");
const NOT_RESET: DriveFault =
    DriveFault::Stopped(RobotStop::new(StopCause::Failure).named("it does not let itself be reset"));
const NOT_ACTIVATED: DriveFault =
    DriveFault::Stopped(RobotStop::new(StopCause::Failure).named("its activation was not over after 20 s"));
const MOVED_BY_OTHERS: DriveFault =
    DriveFault::Stopped(RobotStop::new(StopCause::PendantInControl).named("somebody else moves its fingers"));
const TOLD_BY_OTHERS: DriveFault = DriveFault::Stopped(
    RobotStop::new(StopCause::PendantInControl)
        .named("somebody else tells it where to go, or it does not take it"),
);
