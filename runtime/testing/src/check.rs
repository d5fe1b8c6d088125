//! What makes the verdict on a trial, by the same criteria for every fault.
//!
//! In: a trial and the undisturbed run. Out: that the program ended where the undisturbed run does; or that it stopped
//! as promised, and after how many steps all robots stood; or which promise was broken.

use super::case::{Case, Injected, LinkFault};
use super::trial::Trial;
use super::verdict::Verdict;
use mrroc_core::cell::CellError;
use mrroc_core::fault::{FaultKind, ProcessId, Role};
use mrroc_core::link::Nanos;
use mrroc_core::link::timeout::missed_step_budget;

/// The time for messages: from what a process does until the next process has read it, and until the drives get it
/// \[steps\].
const MESSAGES: u64 = 4;

pub(super) fn check(case: &Case, trial: &Trial, calm: &Trial, end_tolerance: f64) -> Verdict {
    if let Some(wrong) = trial.robots.iter().find_map(|robot| robot.wrong.clone()) {
        return Verdict::Broken(wrong);
    }
    if trial.endless {
        return Verdict::Broken("the cell does not end".to_owned());
    }
    if trial.cut {
        return if trial.hit { Verdict::Survived } else { Verdict::Void };
    }
    let fault = match &trial.outcome {
        Err(CellError::Fault(fault)) => Some(fault),
        Err(other) => return Verdict::Broken(format!("the cell ends with `{other}`")),
        // After its MP was killed, a cell does not report how the program ended.
        Ok(_) if case.injected == Injected::Kill(ProcessId::MP) && trial.hit => None,
        Ok(_) if !trial.hit => return Verdict::Void,
        Ok(_) => return at_the_end(case, trial, calm, end_tolerance),
    };
    if let Some(fault) = fault.filter(|_| case.injected != Injected::Kill(ProcessId::MP)) {
        if is_forged(case) {
            return Verdict::Stopped { steps: 0, bound: 0 };
        }
        let silent = matches!(fault.kind(), FaultKind::CellClosed | FaultKind::StoppedByCell);
        if silent || fault.process().is_none() || fault.step().is_none() {
            return Verdict::Broken(format!("the cause is not reported: {fault}"));
        }
    }
    // The fault was noticed in this step. Its cause is earlier by the budget of missing demands at most, and not before
    // the injected fault.
    let budget = u64::from(missed_step_budget(core::time::Duration::from_nanos(trial.step))) + 1;
    let noticed = fault.and_then(|fault| fault.step()).unwrap_or(case.at);
    let cause = case.at.max(noticed.saturating_sub(budget));
    stands(case, trial, (cause, noticed))
}

/// Checks that a program that ended without a fault left its robots where the undisturbed run leaves them.
fn at_the_end(case: &Case, trial: &Trial, calm: &Trial, tolerance: f64) -> Verdict {
    if is_forged(case) {
        return Verdict::Survived;
    }
    for (robot, calm) in trial.robots.iter().zip(&calm.robots) {
        for (i, (q, calm)) in robot.last().iter().zip(calm.last()).enumerate() {
            // Written so that NaN counts as a difference.
            let is_there = (q - calm).abs() <= tolerance;
            if !is_there {
                let (name, joint) = (&robot.name, i + 1);
                return Verdict::Broken(format!("{name} joint {joint} ends at {q} in place of {calm}"));
            }
        }
    }
    Verdict::Survived
}

/// Checks that all robots stand within the bound and do not move again, and that no robot that stood when the fault was
/// noticed begins to move.
fn stands(case: &Case, trial: &Trial, (cause, noticed): (u64, u64)) -> Verdict {
    let step = trial.step;
    // A falling rate takes time of its own, and drives lag behind their demands.
    let is_sound = matches!(&trial.outcome, Err(CellError::Fault(fault)) if fault.leaves_demands_sound());
    let on_path = is_sound || matches!(case.injected, Injected::Press(_));
    let stop = trial.stop_steps;
    // Words of a stop that come from the other end of a wire are as late as all others, and so was the last demand.
    let messages = match case.injected {
        Injected::Apart(_, wire, _) => MESSAGES + 2 * (u64::from(wire.takes_us[1]) * 1000).div_ceil(step),
        _ => MESSAGES,
    };
    let mut worst = (0, stop + messages);
    for robot in &trial.robots {
        // A robot whose EDP was killed is braked by its drives; a robot whose EDP stood still brakes when the EDP goes
        // on.
        let from = match case.injected {
            Injected::Kill(ProcessId { role: Role::Edp, name }) if is_of(robot, name) => continue,
            Injected::Stall(ProcessId { role: Role::Edp, name }, _) if is_of(robot, name) => case.end(),
            _ => cause,
        };
        let bound = if on_path { (trial.rate_steps + delay(trial).div_ceil(step)).max(stop) } else { stop }
            + messages;
        let steps = robot.stood().div_ceil(step).saturating_sub(from);
        if steps > bound {
            let name = &robot.name;
            return Verdict::Broken(format!("{name} stands {steps} steps after the cause, bound {bound}"));
        }
        if steps * worst.1 > worst.0 * bound {
            worst = (steps, bound);
        }
        // On its path, a robot that has just begun its motion becomes faster before it becomes slower.
        let settling = if on_path { bound } else { messages };
        let settled: Nanos = (noticed.max(case.at) + settling) * step + delay(trial);
        if let Some((began, _)) =
            robot.episodes.iter().find(|(began, _)| *began > settled && *began > from * step)
        {
            let name = &robot.name;
            let steps = began / step - noticed;
            return Verdict::Broken(format!(
                "{name} begins to move {steps} steps after the fault was noticed"
            ));
        }
    }
    Verdict::Stopped { steps: worst.0, bound: worst.1 }
}

/// Whether a sender sends wrong contents: then neither the cause nor the end can be checked.
fn is_forged(case: &Case) -> bool {
    matches!(case.injected, Injected::Link(_, LinkFault::Forge, _))
}

/// How far drives lag behind their demands at most \[ns\]: two steps and two of the slowest servo periods.
fn delay(trial: &Trial) -> Nanos {
    2 * trial.step + 2 * trial.robots.iter().map(|robot| robot.servo()).max().unwrap_or(0)
}

fn is_of(robot: &super::motion_monitor::MotionMonitor, name: Option<mrroc_core::fault::Name>) -> bool {
    name.is_some_and(|name| name.as_str() == robot.name)
}
