//! MP: the master process, the coordinator of all robots.
//!
//! In: the ECPs' replies and its virtual sensors. Out: orders, one per robot of the instruction and step. The
//! MP alone paces the cell: [`clock`] says when a step begins and how much path time it has, [`exchange`] is one
//! scatter and gather, [`instruction`] opens, ends and stops instructions by it, [`motion`] is Move and [`waiting`]
//! Wait; [`restart`] runs the program, and again after a reset.

mod clock;
mod exchange;
mod instruction;
mod motion;
mod operating;
mod restart;
mod telling;
#[cfg(test)]
mod tests;
mod waiting;

use crate::link::Host;
use crate::operator::state::MpState;
use core::any::TypeId;
use core::time::Duration;
use std::rc::Rc;

use crate::control::ecp::MAX_REFUSALS;
use crate::control::guard::Guard;
use crate::control::overruns::Overruns;
use crate::control::replay::Script;
use crate::control::sensing::Sensing;
use crate::link::News;
use crate::model::fault::{Ended, Fault, FaultKind, FaultWords, ProcessId};
use crate::model::image::{RobotImage, Sensor};
use crate::model::list::{RobotHandle, SensorHandle};
use crate::model::robot::Robot;
use crate::model::time::Nanos;
use crate::observe::witness::Witnesses;
use crate::operator::Operator;
use crate::safety::braking::BrakingLaw;
use crate::safety::rate::Feed;
use crate::suggestion::suggestion;

use clock::StepClock;
pub(crate) use exchange::RobotPort;

/// What is called at the start of every step: the cell's index of the step and its operator.
pub(crate) type StepHook = Box<dyn FnMut(u64, &Operator)>;

/// The master process: what the coordinating program is given.
pub struct Mp<'w> {
    host: Host<'w>,
    robots: Vec<RobotPort>,
    sensing: Sensing,
    operator: Operator,
    hook: Option<StepHook>,
    guard: Option<Guard>,
    /// What a guard, the operator or a sensor stops the cell for, on the way to a standstill.
    protective: Option<Fault>,
    /// Whether the operator has asked for one since the step before.
    stopping: bool,
    clock: StepClock,
    /// Ordinal of the instruction opened last.
    ordinal: u32,
    latched: Option<Fault>,
    refusals: u32,
    overruns: Overruns,
    /// How fast all robots of the last exchange may slow down together.
    law: BrakingLaw,
    /// Resets that were tried.
    epoch: u32,
    /// A process that is gone: without it there is no restart.
    gone: Option<ProcessId>,
    witnesses: Witnesses,
    /// Whether the operator was seen to abort in this step.
    aborts: bool,
    /// A replay's steps.
    script: Option<Rc<Script>>,
    /// What an operator is shown.
    shown: MpState,
}

impl<'w> Mp<'w> {
    pub(crate) fn new(
        host: Host<'w>,
        robots: Vec<RobotPort>,
        sensing: Sensing,
        operator: Operator,
        hook: Option<StepHook>,
        (step, grace): (Duration, Nanos),
        rate_change: f64,
    ) -> Mp<'w> {
        let clock = StepClock::new(step.as_nanos() as Nanos, grace, Feed::new(rate_change));
        let (guard, protective, latched) = (None, None, None);
        let (ordinal, refusals, overruns) = (0, 0, Overruns::new(step));
        let (witnesses, aborts, script) = (sensing.witnesses.clone(), false, None);
        let shown = MpState::default();
        Mp {
            host,
            robots,
            sensing,
            operator,
            hook,
            guard,
            law: BrakingLaw::UNLIMITED,
            epoch: 0,
            gone: None,
            protective,
            stopping: false,
            clock,
            ordinal,
            latched,
            refusals,
            overruns,
            witnesses,
            aborts,
            script,
            shown,
        }
    }

    /// Lets a guard watch over all robots.
    pub(crate) fn watch_by(&mut self, guard: Option<Guard>) {
        self.guard = guard.map(|guard| guard.over(self.robots.iter().map(|robot| robot.name)));
    }

    /// The handle of a robot. Each robot has one: pass it on.
    ///
    /// # Errors
    /// `Config` when the cell has no robot of that name and kind, or when its handle is taken.
    pub fn robot<R: Robot>(&mut self, name: &str) -> Result<RobotHandle<R>, Fault> {
        let config = |text: &str| Fault::new(FaultKind::Config).in_process(ProcessId::MP).text(text);
        let Some(index) = self.robots.iter().position(|robot| robot.name.as_str() == name) else {
            let names: Vec<_> = self.robots.iter().map(|robot| robot.name.as_str()).collect();
            let there = suggestion(name, &names, "the cell has");
            return Err(config(&format!("there is no robot `{name}`: {there}")));
        };
        let port = &mut self.robots[index];
        if port.kind != TypeId::of::<R>() {
            let text = format!(
                "robot `{name}` is of another kind than {}: name its own, {}, in `robot::<..>`",
                R::KIND,
                port.kind_name
            );
            return Err(config(&text));
        }
        if core::mem::replace(&mut port.taken, true) {
            return Err(config(&format!("robot `{name}` has a handle already: pass that one on")));
        }
        Ok(RobotHandle { index, name: port.name, image: RobotImage::unknown() })
    }

    /// The handle of a virtual sensor of the MP, in its default configuration.
    ///
    /// # Errors
    /// `Config` when the cell gives the MP no sensor of that name and kind, or when its handle is taken.
    pub fn sensor<S: Sensor>(&mut self, name: &str) -> Result<SensorHandle<S>, Fault>
    where
        S::Configuration: Default,
    {
        self.sensing.handle(name, S::Configuration::default(), ProcessId::MP)
    }

    /// Index of the step that has begun, counted since the cell started.
    #[must_use]
    pub const fn step(&self) -> u64 {
        self.clock.step()
    }

    /// Begins a step, unless one has begun that no exchange has used.
    fn begin_step(&mut self) -> Result<(), Fault> {
        self.keep_to_script();
        let begins = self
            .clock
            .begin(self.host.waiter, self.host.meter)
            .map_err(|_| Fault::orderly(FaultKind::CellClosed))?;
        if begins {
            self.count_own_time()?;
            // A hook that panics is not called again by the stop that follows.
            if let Some(mut hook) = self.hook.take() {
                hook(self.clock.step(), &self.operator);
                self.hook = Some(hook);
            }
            self.follow_script();
            self.hear_operator();
            self.clock.advance(self.wanted_rate(), self.operator.is_suspended());
            self.tell_step()?;
            self.show_step();
        }
        self.hear_news()?;
        self.tell_abort();
        Ok(())
    }

    /// A step that began late because of the MP itself is one of those that may be too many.
    fn count_own_time(&mut self) -> Result<(), Fault> {
        let missed = self.host.meter.own_time() / self.clock.period();
        if self.latched.is_some() {
            return Ok(());
        }
        self.overruns.note(missed).map_err(|fault| fault.in_process(ProcessId::MP).at_step(self.clock.step()))
    }

    /// The rate that robots are to be brought to.
    fn wanted_rate(&self) -> f64 {
        if self.protective.is_some() { 0.0 } else { self.operator.wanted_rate() }
    }

    /// A fault that leaves the demands sound: all robots stop on their paths for it. The first one is kept.
    fn protect(&mut self, fault: Fault) {
        let step = self.clock.step();
        self.protective.get_or_insert_with(|| fault.in_process(ProcessId::MP).at_step(step));
    }

    /// Acts on what happened outside of the cell's messages. While robots stop nothing more is to be done about it.
    fn hear_news(&mut self) -> Result<(), Fault> {
        match self.host.notices.news() {
            Some(News::Lost(process)) => {
                self.gone.get_or_insert(process);
                if self.latched.is_some() {
                    return Ok(());
                }
                Err(Fault::new(FaultKind::PeerLost).in_process(process).at_step(self.clock.step()))
            }
            // From the terminal: the program is to end, and not to be started again.
            Some(News::Abort) => {
                self.operator.abort();
                self.operator.give_up();
                Ok(())
            }
            None => Ok(()),
        }
    }

    /// A fault in an instruction: unless it ended at standstill by itself, all robots stop; it is latched.
    fn conclude(&mut self, fault: Fault) -> Fault {
        let fault = fault.in_process(ProcessId::MP).at_step(self.clock.step());
        self.shown.fault = Some(FaultWords::from(&fault));
        // What goes wrong while a guard's stop is under way is not its cause.
        let fault = match &self.protective {
            Some(protective) if exchange::precedes(protective, &fault) => protective.clone(),
            Some(_) | None => fault,
        };
        // An abort, a Wait that was too long: nothing moves and nothing is wrong with the cell.
        if fault.is_orderly() { fault } else { self.stop(fault) }
    }

    /// One Move or Wait, from the operator's point of view: what can be aborted. Robots that it hands over moving
    /// are the next one's, and so is an abort that came too late for it.
    fn instruction<T>(&mut self, work: impl FnOnce(&mut Self) -> Result<T, Fault>) -> Result<T, Fault> {
        self.check_latch()?;
        if self.robots.iter().all(|robot| !robot.handed_over) {
            // What a program does while its robots stand makes no step late.
            self.host.meter.own_time();
        }
        self.operator.begin();
        let outcome = self.carry_out(work);
        self.show_end();
        outcome
    }

    fn carry_out<T>(&mut self, work: impl FnOnce(&mut Self) -> Result<T, Fault>) -> Result<T, Fault> {
        let outcome = work(self).map_err(|fault| self.conclude(fault));
        if outcome.is_ok() && self.robots.iter().any(|robot| robot.handed_over) {
            return outcome;
        }
        let aborted = self.operator.end();
        if outcome.is_ok() && (aborted || self.protective.is_some()) {
            // An abort that the instruction's own end forestalled is an abort: the program must not go on.
            let fault = self.ending();
            return Err(self.conclude(fault));
        }
        outcome
    }

    /// Whether the open instruction is to end at standstill on its path: the operator aborts it, or a guard does.
    fn is_ending(&self) -> bool {
        self.protective.is_some() || self.operator.is_aborting()
    }

    /// What such an instruction ends with.
    fn ending(&self) -> Fault {
        let fault = self.protective.clone().unwrap_or_else(|| Fault::orderly(FaultKind::Aborted));
        fault.in_process(ProcessId::MP).at_step(self.clock.step())
    }

    /// Shows the guard what the robots reported, and lets it look.
    fn let_guard_look(&mut self) {
        let Some(guard) = &mut self.guard else { return };
        for (i, robot) in self.robots.iter().enumerate() {
            if let Some(view) = robot.view() {
                guard.see(i, view);
            }
        }
        let step = self.clock.step();
        if self.protective.is_none() && guard.is_due(step) {
            self.protective = guard.look(step).err().map(|fault| fault.of_guard().at_step(step));
        }
    }

    fn check_latch(&mut self) -> Result<(), Fault> {
        let Some(fault) = &self.latched else { return Ok(()) };
        let fault = fault.clone();
        self.refuse();
        // A refused call takes a step: a program that ignores the fault cannot stop the cell's time.
        self.clock.spend();
        self.begin_step()?;
        Err(fault)
    }

    /// Ends a program that loops over refused instructions, through the process's own boundary.
    fn refuse(&mut self) {
        self.refusals += 1;
        if self.refusals > MAX_REFUSALS {
            self.refusals = 0;
            std::panic::resume_unwind(Box::new(Ended("ended by the runtime: it ignores a latched fault")));
        }
    }
}
