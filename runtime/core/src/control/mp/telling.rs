//! What the MP tells those who watch, and what a replay tells the MP.
//!
//! In: a step that begins, an operator who aborts, a fault; in a replay the recorded steps. Out: the same to observers; in a
//! replay the steps and the operator's wishes of the recording.

use std::rc::Rc;

use crate::control::replay::Script;
use crate::model::fault::{Fault, FaultKind};
use crate::observe::step_observer::{StepEvent, StepRecord};
use crate::safety::latch::Latch;

use super::Mp;

impl Mp<'_> {
    /// Begins the steps of a recording, and no others, and lets the operator want what he wanted then.
    pub(crate) fn follow(&mut self, script: Option<Rc<Script>>) {
        self.script = script;
    }

    /// The step that begins next is the recording's.
    pub(super) fn keep_to_script(&mut self) {
        if let Some(script) = &self.script {
            self.clock.not_before(script.after(self.clock.step()));
        }
    }

    /// The operator wants what he wanted in this step of the recording.
    pub(super) fn follow_script(&self) {
        if let Some(script) = &self.script {
            script.begin(self.clock.step(), &self.operating.operator);
        }
    }

    /// Tells of the step that has begun. The cell is closing when who watches has seen enough.
    pub(super) fn tell_step(&mut self) -> Result<(), Fault> {
        let step = self.clock.step();
        self.operating.aborts = self.operating.operator.is_aborting();
        let stopping = core::mem::take(&mut self.operating.stopping);
        if !self.step_observers.is_watched() {
            return Ok(());
        }
        if self.step_observers.is_over(step) {
            self.stops.refuse();
            return Err(Fault::orderly(FaultKind::CellClosed));
        }
        let record = StepRecord {
            step,
            dt: self.clock.dt(),
            duration: self.clock.duration(),
            speed: self.operating.operator.speed(),
            suspended: self.clock.is_suspended(),
            reduced: self.operating.is_slow,
            aborting: self.operating.aborts,
            stopping,
            resetting: self.operating.operator.latch() == Latch::Resetting,
        };
        self.step_observers.show(self.host.waiter.now(), &StepEvent::Step(record), &[]);
        Ok(())
    }

    /// Tells of an operator who has aborted since the step began.
    pub(super) fn tell_abort(&mut self) {
        let step = self.clock.step();
        if let Some(script) = &self.script {
            script.go_on(step, &self.operating.operator);
        }
        if !self.operating.aborts && self.operating.operator.is_aborting() {
            self.operating.aborts = true;
            self.step_observers.show(self.host.waiter.now(), &StepEvent::Abort { step }, &[]);
        }
    }

    /// What took place in this step moved nothing: what comes next may take place in it, unless it is too late for that.
    pub(super) fn keep_unless_late(&mut self) {
        let step = self.clock.step();
        match &self.script {
            // The recorded run has found that out, and the time of a replay does not tell it.
            Some(script) if script.was_late(step) => self.clock.spend(),
            Some(_) => self.clock.keep(),
            None => self.clock.keep_unless_late(self.host.waiter),
        }
        if self.clock.is_spent() {
            self.step_observers.show(self.host.waiter.now(), &StepEvent::Late { step }, &[]);
        }
    }

    /// Tells of the fault that the cell stops for.
    pub(super) fn tell_stop(&self, fault: &Fault) {
        if self.stops.latched.is_none() {
            let step = self.clock.step();
            self.step_observers.show_fault(self.host.waiter.now(), &StepEvent::Fault { step }, Some(fault));
        }
    }
}
