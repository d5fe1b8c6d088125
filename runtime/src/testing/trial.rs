//! A trial: a cell run on the memory link with a fault, and everything that its drives were told.

use core::time::Duration;
use std::cell::RefCell;
use std::rc::Rc;

use super::case::{Case, Channel, Injected, Press};
use super::link::FaultyLink;
use super::onlooker::Onlooker;
use super::stage::{Lasting, Stage};
use crate::cell::{Cell, CellError, RunReport, first_cause};
use crate::fault::ProcessId;
use crate::link::Nanos;
use crate::link::memory::Scheduler;
use crate::operator::Operator;

/// What came of a trial.
pub(super) struct Trial {
    /// How the programs ended; a process that was killed reports nothing.
    pub outcome: Result<RunReport, CellError>,
    pub robots: Vec<Onlooker>,
    pub processes: Vec<ProcessId>,
    pub channels: Vec<Channel>,
    /// Whether the fault had anything to be done to.
    pub hit: bool,
    /// Whether it had to be given up: it would not have ended.
    pub endless: bool,
    /// When the MP's program was over, or gone \[ns\].
    pub over: Nanos,
    /// The cell's step \[ns\].
    pub step: Nanos,
    /// Steps in which all robots stand after the cause of a stop, by their limits and the budget of missing demands.
    pub stop_steps: u64,
    /// Steps in which robots stop on their path: their rate falls.
    pub rate_steps: u64,
}

/// Runs a cell with a fault, or without one.
///
/// # Errors
/// What is wrong with the cell's set-up.
pub(super) fn attempt(mut cell: Cell, case: Option<Case>, lasting: Lasting) -> Result<Trial, CellError> {
    cell.check()?;
    let step = cell.step_length();
    let nanos = step.as_nanos() as Nanos;
    let stage = Rc::new(Stage::new(case, nanos, lasting));
    if let Some(Case { injected: Injected::Press(press), at, .. }) = case {
        let stage = Rc::clone(&stage);
        cell = cell.also_on_step(move |step, operator| {
            if play(press, at, step, operator) {
                stage.hits.set(1);
            }
        });
    }
    let mut onlookers = Vec::new();
    for robot in cell.robots_mut() {
        let onlooker = Rc::new(RefCell::new(Onlooker::new(robot.name(), robot.bounds())));
        robot.show(Rc::clone(&onlooker));
        onlookers.push(onlooker);
    }
    let (rate_steps, stop_steps) = (cell.rate_steps(), cell.stop_steps());
    let mut scheduler = Scheduler::new();
    let assembly = cell.put_on(&mut FaultyLink { scheduler: &mut scheduler, stage: Rc::clone(&stage) })?;
    let time = scheduler.run();
    let killed = |process: &ProcessId| stage.kills(*process);
    let outcomes = assembly.outcomes.take();
    let told: Vec<_> = outcomes.into_iter().filter(|(process, _)| !killed(process)).collect();
    let outcome = match time {
        Err(stuck) => Err(stuck.into()),
        Ok(time) => first_cause(&told)
            .map(|()| RunReport { steps: assembly.steps.get(), time: Duration::from_nanos(time) })
            .map_err(CellError::from),
    };
    let robots = onlookers.iter().map(|onlooker| onlooker.borrow().clone()).collect();
    Ok(Trial {
        outcome,
        robots,
        processes: stage.processes.take(),
        channels: stage.channels.take(),
        hit: stage.hits.get() > 0 || matches!(case, Some(Case { injected: Injected::Own(_), .. })),
        endless: stage.given_up.get(),
        over: stage.over.get().unwrap_or(stage.now.get()),
        step: nanos,
        stop_steps,
        rate_steps,
    })
}

/// What the operator does in a step; whether there is anything to be done to.
fn play(press: Press, at: u64, step: u64, operator: &Operator) -> bool {
    let running = operator.is_running();
    match press {
        Press::SuspendAndResume(_) if step == at => operator.suspend(),
        Press::SuspendAndResume(steps) if step == at + u64::from(steps) => operator.resume(),
        Press::Abort if step == at => operator.abort(),
        Press::Stop if step == at => operator.protective_stop(),
        Press::Everything if step == at => {
            operator.suspend();
            operator.abort();
            operator.resume();
        }
        Press::SuspendAndResume(_) | Press::Abort | Press::Stop | Press::Everything => return false,
    }
    running
}
