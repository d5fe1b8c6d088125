//! A trial: one run of a cell on the memory link with a fault.
//!
//! In: a cell and a case. Out: how the programs ended, and all demands that the drives got.

use core::time::Duration;
use std::cell::RefCell;
use std::rc::Rc;

use super::case::{Case, Channel, Injected, Press};
use super::forks::{Forks, Lasting};
use super::link::FaultyLink;
use super::motion_monitor::{Bounds, MotionMonitor};
use super::stage::Stage;
use mrroc_core::cell::{Cell, CellError, RunReport, first_cause};
use mrroc_core::fault::ProcessId;
use mrroc_core::link::Nanos;
use mrroc_core::link::memory::Scheduler;
use mrroc_core::operator::Operator;

/// The result of a trial.
pub(super) struct Trial {
    /// How the programs ended; a killed process reports nothing.
    pub outcome: Result<RunReport, CellError>,
    pub robots: Vec<MotionMonitor>,
    pub processes: Vec<ProcessId>,
    pub channels: Vec<Channel>,
    /// Whether the fault was applied.
    pub hit: bool,
    /// Whether the trial was given up, because it did not end.
    pub endless: bool,
    /// Whether the trial was watched for long enough, but not to its end.
    pub cut: bool,
    /// The case, if any.
    pub case: Option<Case>,
    /// The copies of the run.
    pub forks: Forks,
    /// When the MP's program was over or the MP was gone \[ns\].
    pub over: Nanos,
    /// The cell's step \[ns\].
    pub step: Nanos,
    /// The bound in which all robots stand after the cause of a stop, from their limits and the budget of missing
    /// demands \[steps\].
    pub stop_steps: u64,
    /// The bound in which robots stop on their path, while their rate falls \[steps\].
    pub rate_steps: u64,
}

/// What is injected into the cell of a trial.
pub(super) enum Part {
    /// Nothing.
    Calm,
    One(Case),
    /// Nothing in the run itself; a fault in each of its copies.
    Copied(Forks),
}

/// Runs a cell with a fault, or without one. A copy of the run returns from this function as well.
///
/// # Errors
/// What is wrong with the cell's set-up.
pub(super) fn attempt(mut cell: Cell, part: Part, lasting: Lasting) -> Result<Trial, CellError> {
    cell.check()?;
    let step = cell.step_length();
    let nanos = step.as_nanos() as Nanos;
    let is_press = |case: Case| matches!(case.injected, Injected::Press(_));
    let (case, forks) = match part {
        Part::Calm => (None, None),
        Part::One(case) => (Some(case), None),
        Part::Copied(forks) => (None, Some(forks)),
    };
    let presses = forks.is_some() || case.is_some_and(is_press);
    let stage = Rc::new(Stage::new(case, nanos, lasting));
    if let Some(forks) = forks {
        *stage.forks.borrow_mut() = forks;
    }
    if presses {
        let stage = Rc::clone(&stage);
        cell = cell.also_on_step(move |step, operator| {
            let Some(Case { injected: Injected::Press(press), at, .. }) = stage.case.get() else { return };
            if play(press, at, step, operator) {
                stage.hits.set(1);
            }
        });
    }
    let layout = cell.layout();
    let monitors: Rc<[RefCell<MotionMonitor>]> = layout
        .robots
        .iter()
        .map(|robot| RefCell::new(MotionMonitor::new(&robot.name, Bounds::of(robot))))
        .collect();
    let seeing = Rc::clone(&monitors);
    let cell = cell.watch(move |seen| {
        // The end of the servo period, converted from seconds back to nanoseconds.
        let end = (seen.time * 1e9).round() as Nanos;
        let of_robot = seeing.iter().find(|monitor| monitor.borrow().name == seen.robot);
        of_robot.into_iter().for_each(|monitor| monitor.borrow_mut().see(end, seen.demanded));
    });
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
    let robots = monitors.iter().map(|monitor| monitor.borrow().clone()).collect();
    Ok(Trial {
        outcome,
        robots,
        processes: stage.processes.take(),
        channels: stage.channels.take(),
        case: stage.case.get(),
        forks: stage.forks.take(),
        hit: stage.hits.get() > 0 || matches!(case, Some(Case { injected: Injected::Own(_), .. })),
        endless: stage.given_up.get(),
        cut: stage.cut.get(),
        over: stage.over.get().unwrap_or(stage.now.get()),
        step: nanos,
        stop_steps,
        rate_steps,
    })
}

/// Does what the operator does in a step; returns whether that was possible.
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
