//! The operator: suspend, resume, abort, stop, speed; and after a fault acknowledge, reset.

use std::sync::atomic::{AtomicBool, AtomicU8, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use super::hold::{Hold, Renewal};
use super::jog::JogOrder;
use crate::model::fault::Fault;
use crate::model::name::Name;
use crate::model::time::Nanos;
use crate::safety::latch::{Event, Latch, LatchRefusal, Latching};

/// The operator's handle of a cell. It may be cloned and used from any thread.
///
/// Speed and Suspend scale the path time of every step with a bounded change of rate, so that the robots slow
/// down on their paths; Abort stops on the path too and then ends the instruction with a fault; Stop ends the cell so.
///
/// After a fault stop the cell is latched. One that [awaits a reset](crate::cell::AfterFault) starts its programs again when
/// its operator has acknowledged the fault and then pressed the reset:
///
/// ```
/// # use mrroc::operator::{Latch, Operator};
/// # fn react(operator: &Operator) -> Result<(), mrroc::operator::LatchRefusal> {
/// if let (Latch::Latched, Some(fault)) = (operator.latch(), operator.fault()) {
///     println!("{fault}");
///     operator.acknowledge()?;
///     operator.reset()?;
/// }
/// # Ok(()) }
/// ```
#[derive(Clone, Debug, Default)]
pub struct Operator {
    shared: Arc<Shared>,
}

#[derive(Debug, Default)]
struct Shared {
    /// Bits of the speed, counted from those of full speed, which is the default.
    speed: AtomicU64,
    suspended: AtomicBool,
    /// One of the stages below.
    stage: AtomicU8,
    /// A [`Latching`] in one word.
    latching: AtomicU8,
    /// The fault that is latched. It is written only while the robots stand.
    report: Mutex<Report>,
    given_up: AtomicBool,
    /// Robots look for their reference marks.
    homing: AtomicBool,
    /// A protective stop that the MP has not seen yet.
    protective: AtomicBool,
    /// Robots move only while a hold lasts, and slowly.
    reduced: AtomicBool,
    /// The word of the newest renewal, and the number of the newest hold that was let go, each and 1; 0 before any.
    renewal: AtomicU64,
    let_go: AtomicU64,
    /// Whether a hold lasts, as the MP has found it.
    held: AtomicBool,
    /// How often something was asked of a robot that is jogged, and what.
    jogged: AtomicU64,
    jogs: Mutex<AskedJogs>,
}

/// What was asked of robots that are jogged.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct AskedJogs {
    /// The jog of the newest hold that is one, with the number of that hold.
    pub newest: Option<(u64, Name, JogOrder)>,
    /// The robot whose jogging was said to be done last.
    pub done: Option<Name>,
}

/// Jogs were just being written: what is asked for is not known in this step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Contended;

/// What an operator is told of a latched cell.
#[derive(Debug, Default)]
struct Report {
    cause: Option<Fault>,
    persisting: Option<Fault>,
}

/// No Move or Wait of the MP is at work.
const IDLE: u8 = 0;
/// One is.
const RUNNING: u8 = 1;
/// The operator aborts it.
const ABORTING: u8 = 2;

/// The bits of full speed.
const FULL: u64 = 1.0_f64.to_bits();

/// A speed that is no share of the planned one.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("speed {0} is not within 0 to 1 (0 to 100 % of the plan)")]
pub struct BadSpeed(pub f64);

impl Operator {
    /// An operator who has pressed nothing, at full speed.
    pub fn new() -> Operator {
        Operator::default()
    }

    /// Sets the speed as a share of the planned one, 0 to 1.
    ///
    /// # Errors
    /// [`BadSpeed`] when it is not; the speed stays as it was.
    pub fn set_speed(&self, speed: f64) -> Result<(), BadSpeed> {
        if !(0.0..=1.0).contains(&speed) {
            return Err(BadSpeed(speed));
        }
        self.shared.speed.store(speed.to_bits() ^ FULL, Ordering::Release);
        Ok(())
    }

    /// The speed that is set.
    #[must_use]
    pub fn speed(&self) -> f64 {
        f64::from_bits(self.shared.speed.load(Ordering::Acquire) ^ FULL)
    }

    /// Stops all robots on their paths; the instruction goes on at [`resume`](Operator::resume).
    pub fn suspend(&self) {
        self.shared.suspended.store(true, Ordering::Release);
    }

    /// Reduced speed: robots move only while a person [holds](Operator::renew_hold), and no tool faster than
    /// [`REDUCED_SPEED`](super::REDUCED_SPEED), which is checked where demands are accepted. Robots that move come to a
    /// standstill first. At its end the cell stays suspended until it is [resumed](Operator::resume).
    ///
    /// This replaces neither an enabling device nor an emergency stop.
    pub fn set_reduced(&self, reduced: bool) {
        if !reduced && self.is_reduced() {
            self.suspend();
        }
        self.shared.reduced.store(reduced, Ordering::Release);
    }

    /// Whether the cell is at reduced speed.
    #[must_use]
    pub fn is_reduced(&self) -> bool {
        self.shared.reduced.load(Ordering::Acquire)
    }

    /// Says that a person holds what lets robots move at [reduced speed](Operator::set_reduced): the first time begins the
    /// hold, which ends [`LAPSE`](super::LAPSE) after its last renewal. One that has ended stays so.
    ///
    /// ```
    /// # use mrroc_core::operator::{Operator, Renewal};
    /// # fn pressed(operator: &Operator, milliseconds_of_machine: u64) -> Option<()> {
    /// let mut renewal = Renewal::first(milliseconds_of_machine);
    /// operator.renew_hold(renewal);
    /// // A tenth of a second later:
    /// renewal = renewal.next()?;
    /// operator.renew_hold(renewal);
    /// // The person lets go.
    /// operator.let_go(renewal.hold());
    /// # Some(()) }
    /// ```
    pub fn renew_hold(&self, renewal: Renewal) {
        self.shared.renewal.fetch_max(renewal.to_word().saturating_add(1), Ordering::AcqRel);
    }

    /// Ends a hold, and all before it: robots stop on their paths.
    pub fn let_go(&self, hold: u64) {
        self.shared.let_go.fetch_max(hold.saturating_add(1), Ordering::AcqRel);
    }

    /// Says that a person holds what jogs a robot at [reduced speed](Operator::set_reduced): a [hold](Operator::renew_hold) as any,
    /// which moves this robot alone: with another robot it renews nothing. It moves nothing while no program lets the robot be
    /// [jogged](super::jog::JogPanel), or while another robot moves by its program.
    ///
    /// ```
    /// # use mrroc_core::fault::Name;
    /// # use mrroc_core::operator::jog::JogOrder;
    /// # use mrroc_core::operator::{Operator, Renewal};
    /// # fn pressed(operator: &Operator, milliseconds_of_machine: u64) -> Result<(), Box<dyn std::error::Error>> {
    /// // Along the tool's x axis, at a fifth of the largest jogging speed; to be said again within 300 ms, with the next renewal.
    /// let order = JogOrder::read(&mut "tool x 20%".split_whitespace())?;
    /// operator.jog(Renewal::first(milliseconds_of_machine), Name::new("left")?, order);
    /// # Ok(()) }
    /// ```
    pub fn jog(&self, renewal: Renewal, robot: Name, order: JogOrder) {
        let mut renews = true;
        self.change_jogs(|jogs| match jogs.newest {
            Some((hold, held, _)) if hold == renewal.hold() && held != robot => renews = false,
            Some((hold, ..)) if hold > renewal.hold() => {}
            Some(_) | None => jogs.newest = Some((renewal.hold(), robot, order)),
        });
        if renews {
            self.renew_hold(renewal);
        }
    }

    /// Says that the person has done with jogging a robot: the Move that lets it be jogged ends, and its program goes on.
    pub fn end_jog(&self, robot: Name) {
        self.change_jogs(|jogs| jogs.done = Some(robot));
    }

    fn change_jogs(&self, change: impl FnOnce(&mut AskedJogs)) {
        change(&mut self.shared.jogs.lock().unwrap_or_else(PoisonError::into_inner));
        self.shared.jogged.fetch_add(1, Ordering::AcqRel);
    }

    /// What was asked of robots that are jogged, if it was since `seen`, which it counts on. A step that finds it being changed
    /// waits for nothing: the next one looks again.
    ///
    /// # Errors
    /// [`Contended`]
    pub(crate) fn asked_jogs(&self, seen: &mut u64) -> Result<Option<AskedJogs>, Contended> {
        let jogged = self.shared.jogged.load(Ordering::Acquire);
        if jogged == *seen {
            return Ok(None);
        }
        let mut jogs = self.shared.jogs.try_lock().map_err(|_| Contended)?;
        *seen = jogged;
        // That it is done is said once.
        Ok(Some(AskedJogs { done: jogs.done.take(), newest: jogs.newest }))
    }

    /// Whether a console has asked to jog, or to be done, since this much was seen.
    #[inline]
    pub(crate) fn has_asked_to_jog(&self, seen: u64) -> bool {
        self.shared.jogged.load(Ordering::Acquire) != seen
    }

    /// The number of the hold that lasts at `now` \[ns\].
    pub(crate) fn lasting_hold(&self, hold: &mut Hold, now: Nanos) -> Option<u64> {
        let renewal = self.shared.renewal.load(Ordering::Acquire).checked_sub(1).map(Renewal::from_word);
        let let_go = self.shared.let_go.load(Ordering::Acquire).checked_sub(1);
        hold.lasts(renewal, let_go, now).then(|| hold.lasting()).flatten()
    }

    /// A hold lasts, or none does.
    pub(crate) fn show_held(&self, held: bool) {
        self.shared.held.store(held, Ordering::Release);
    }

    /// Whether a hold lasts.
    #[must_use]
    pub fn is_held(&self) -> bool {
        self.shared.held.load(Ordering::Acquire)
    }

    /// Continues a suspended instruction.
    pub fn resume(&self) {
        self.shared.suspended.store(false, Ordering::Release);
    }

    /// Stops all robots on their paths and ends the present instruction with a fault of kind `Aborted`.
    ///
    /// Refused while nothing [runs](Operator::is_running): there is nothing to abort, and the next instruction is
    /// not aborted for it. Pressed again while it is being carried out, it changes nothing.
    pub fn abort(&self) {
        let _ = self.shared.stage.compare_exchange(RUNNING, ABORTING, Ordering::AcqRel, Ordering::Acquire);
    }

    /// Whether a Move or a Wait of the MP is at work, or has handed moving robots over to the next one: what can
    /// be aborted.
    #[must_use]
    pub fn is_running(&self) -> bool {
        self.shared.stage.load(Ordering::Acquire) != IDLE
    }

    /// Whether the cell is suspended; at reduced speed also while nobody holds.
    #[must_use]
    pub fn is_suspended(&self) -> bool {
        self.shared.suspended.load(Ordering::Acquire) || self.is_reduced() && !self.is_held()
    }

    /// Stops all robots on their paths and latches the cell, as a guard's protective stop does. It has priority over whatever
    /// else is asked: pressed between two instructions it lets the next one move nothing, pressed during a reset it ends that.
    pub fn protective_stop(&self) {
        self.shared.protective.store(true, Ordering::Release);
    }

    /// The protective stop that was pressed since it was asked for last.
    pub fn take_protective_stop(&self) -> bool {
        self.shared.protective.swap(false, Ordering::AcqRel)
    }

    /// Where the cell is between a fault and its restart.
    #[must_use]
    pub fn latch(&self) -> Latch {
        Latching::from_word(self.shared.latching.load(Ordering::Acquire)).latch
    }

    /// The first cause of the stop, once the robots stand.
    #[must_use]
    pub fn fault(&self) -> Option<Fault> {
        self.report(|report| report.cause.clone())
    }

    /// What forbids a reset, or made the last one fail: a process that does not answer, a robot that moves, a drive that
    /// does not come on again, what a guard sees.
    #[must_use]
    pub fn persisting(&self) -> Option<Fault> {
        self.report(|report| report.persisting.clone())
    }

    /// Acknowledges the fault that is latched. Nothing moves by it.
    ///
    /// # Errors
    /// [`LatchRefusal`]: no fault is latched, or the robots do not stand yet.
    pub fn acknowledge(&self) -> Result<(), LatchRefusal> {
        self.meet(Event::Acknowledge)
    }

    /// Resets an acknowledged fault, as a button that is pressed and let go: drives come on where the robots are, and the
    /// programs start again from their first line. Nothing moves before a program orders it. Where a reset fails, the cell
    /// is latched again: see [`persisting`](Operator::persisting).
    ///
    /// # Errors
    /// [`LatchRefusal`]: why it does nothing.
    pub fn reset(&self) -> Result<(), LatchRefusal> {
        let pressed = self.press_reset(true);
        if pressed != Err(LatchRefusal::Held) {
            self.press_reset(false)?;
        }
        pressed
    }

    /// The level of a reset button, for whom has one: what counts is its rising edge after the acknowledgement.
    ///
    /// # Errors
    /// [`LatchRefusal`]: why pressing it does nothing; it has to be let go and pressed again.
    pub fn press_reset(&self, pressed: bool) -> Result<(), LatchRefusal> {
        self.meet(Event::Reset { pressed })
    }

    /// Ends a cell that awaits a reset: it returns with the first cause. Before a fault it makes the next one end the cell.
    pub fn give_up(&self) {
        self.shared.given_up.store(true, Ordering::Release);
    }

    /// Whether the operator has given the latched cell up.
    pub fn has_given_up(&self) -> bool {
        self.shared.given_up.load(Ordering::Acquire)
    }

    /// Something happened to the latch.
    pub(crate) fn meet(&self, event: Event) -> Result<(), LatchRefusal> {
        let latching = &self.shared.latching;
        let mut word = latching.load(Ordering::Acquire);
        loop {
            let (next, outcome) = Latching::from_word(word).meet(event);
            match latching.compare_exchange(word, next.to_word(), Ordering::AcqRel, Ordering::Acquire) {
                Ok(_) => return outcome,
                Err(other) => word = other,
            }
        }
    }

    /// All robots stand for a cause, or as far as they can be brought to.
    pub fn show_cause(&self, cause: &Fault) {
        self.report(|report| report.cause = Some(cause.clone()));
    }

    /// What forbids a reset now, or made the last one fail.
    pub fn show_persisting(&self, persisting: Option<Fault>) {
        self.report(|report| report.persisting = persisting);
    }

    /// The programs start again: nothing is latched any more.
    pub fn forget(&self) {
        self.report(|report| *report = Report::default());
    }

    fn report<T>(&self, look: impl FnOnce(&mut Report) -> T) -> T {
        // A report is whole whatever a thread that held it did.
        look(&mut self.shared.report.lock().unwrap_or_else(PoisonError::into_inner))
    }

    /// Whether the operator aborts the instruction that is carried out.
    pub fn is_aborting(&self) -> bool {
        self.shared.stage.load(Ordering::Acquire) == ABORTING
    }

    /// Robots look for their reference marks, or no longer do.
    pub fn show_homing(&self, homing: bool) {
        self.shared.homing.store(homing, Ordering::Release);
    }

    /// Whether robots look for their reference marks, before the programs begin.
    pub fn is_homing(&self) -> bool {
        self.shared.homing.load(Ordering::Acquire)
    }

    /// An instruction begins, or takes over from the one before it with its abort.
    pub fn begin(&self) {
        let _ = self.shared.stage.compare_exchange(IDLE, RUNNING, Ordering::AcqRel, Ordering::Acquire);
    }

    /// The instruction is over, at standstill; whether it was being aborted.
    pub fn end(&self) -> bool {
        self.shared.stage.swap(IDLE, Ordering::AcqRel) == ABORTING
    }

    /// The rate that the operator wants now.
    pub fn wanted_rate(&self) -> f64 {
        if self.is_suspended() || self.is_aborting() { 0.0 } else { self.speed() }
    }
}
