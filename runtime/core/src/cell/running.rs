//! How a cell is checked, and run on the memory link.
//!
//! In: a cell. Out: what its run took, or everything that is wrong with it before anything moves.

use core::time::Duration;
use std::rc::Rc;
use std::sync::Arc;

use crate::link::memory::{Pulse, Scheduler};
use crate::link::watchdog::Watchdog;
use crate::model::fault::{Fault, FaultKind, ProcessId, Role};
use crate::model::name::Name;
use crate::model::time::Clock;
use crate::observe::step_observer::StepObserver;

use super::{Cell, CellError};

/// What a run took.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RunReport {
    /// Steps.
    pub steps: u64,
    /// Time on the cell's clock.
    pub time: Duration,
}

impl Cell {
    /// Runs the cell on the memory link, under the virtual clock, until the MP's program is over.
    ///
    /// # Errors
    /// [`CellError`]: what is wrong with the set-up, before anything moves; or the first cause of a stop.
    pub fn run(mut self) -> Result<RunReport, CellError> {
        let names = self.check()?;
        let record = self.watching.begin_record(&self.layout())?;
        if let Some(record) = &record {
            self = self.observed_in_all_cells_by(Rc::clone(record) as Rc<dyn StepObserver>);
        }
        let subscriptions = self.begin_subscriptions(None, Clock::Virtual);
        for shown in &subscriptions {
            self = self.observed_by(Rc::clone(shown) as Rc<dyn StepObserver>);
        }
        let outcome = self.run_on_memory(&names);
        // Bodies that were given up keep theirs.
        record.iter().chain(&subscriptions).for_each(|record| record.finish());
        outcome
    }

    /// Runs a cell in which nothing is wrong.
    pub fn run_on_memory(mut self, names: &[Name]) -> Result<RunReport, CellError> {
        // All processes are in this one.
        for observer in self.take_observers_of_picture() {
            self = self.observed_by(Rc::new(observer));
        }
        let mut scheduler = Scheduler::new();
        let timeout = self.timing.watchdog;
        let assembly = self.assemble(names, &mut scheduler)?;
        let _watchdog = timeout.map(|timeout| {
            let pulse = Arc::<Pulse>::default();
            scheduler.show(Arc::clone(&pulse));
            Watchdog::new(scheduler.names(), pulse, timeout)
        });
        let time = scheduler.run()?;
        first_cause(&assembly.outcomes.borrow())?;
        Ok(RunReport { steps: assembly.steps.get(), time: Duration::from_nanos(time) })
    }

    /// The robots' names, when nothing is wrong with the set-up.
    ///
    /// # Errors
    /// [`CellError`]: everything that is wrong with it.
    pub fn check(&mut self) -> Result<Vec<Name>, CellError> {
        if self.timing.step.is_zero() {
            return Err(CellError::Step);
        }
        let mut errors = core::mem::take(&mut self.parts.errors);
        self.parts.check_size(&mut errors);
        let names = self.parts.check_robots(&self.timing, &mut errors);
        self.parts.check_sensors(&names, self.timing.step, &mut errors);
        self.parts.check_named(&mut errors);
        self.parts.check_cells(&names, &mut errors);
        let layout = self.watching.recording.as_ref().map(|_| self.layout());
        let unrecorded =
            self.watching.recording.iter().zip(&layout).flat_map(|(asked, layout)| asked.check(layout));
        errors.extend(unrecorded.map(CellError::from));
        let misplaced =
            |error: &CellError| matches!(error, CellError::NoRobot(..) | CellError::OtherKind { .. });
        let has_program = self.coordination.program.is_some() || self.parts.has_program();
        if !has_program && !errors.iter().any(misplaced) {
            errors.push(CellError::NoProgram);
        }
        CellError::all(errors).map(|()| names)
    }
}

/// The MP's fault, or else the first of an ECP's.
pub fn first_cause(outcomes: &[(ProcessId, Result<(), Fault>)]) -> Result<(), Fault> {
    let mp = outcomes.iter().filter(|(process, _)| process.role == Role::Mp);
    let others = outcomes.iter().filter(|(process, _)| process.role != Role::Mp);
    for (process, outcome) in mp.chain(others) {
        if let Err(fault) = outcome {
            if fault.kind() == FaultKind::CellClosed {
                let text = "it waits for an instruction, but the MP's program is over: write `serve_all`, or let the MP order one more";
                return Err(Fault::thrown(text).in_process(*process));
            }
            return Err(fault.clone());
        }
    }
    Ok(())
}
