//! What the MP stops the cell for: the fault that is latched, and a protective stop on the path.
//!
//! In: faults, what a guard sees, processes that are gone. Out: the first cause, which every instruction is refused with until
//! a reset.

use crate::control::ecp::MAX_REFUSALS;
use crate::control::guard::Guard;
use crate::model::fault::{Ended, Fault, FaultKind, ProcessId};

use super::robots::RobotPorts;

/// Causes of stops.
pub(super) struct Stops {
    /// The MP that they are of.
    process: ProcessId,
    /// The first cause of a stop that is over, until a reset.
    pub latched: Option<Fault>,
    /// What a guard, the operator or a sensor stops the cell for, until it stands still.
    pub protective: Option<Fault>,
    /// What looks at all robots.
    pub guard: Option<Guard>,
    /// How many stops were asked for directly, past the launcher.
    pub asked: u64,
    /// A process that is gone: without it there is no restart.
    pub gone: Option<ProcessId>,
    /// Instructions that the program began although a fault was latched.
    refusals: u32,
}

impl Stops {
    /// None, of this MP.
    pub const fn of(process: ProcessId) -> Stops {
        Stops { process, latched: None, protective: None, guard: None, asked: 0, gone: None, refusals: 0 }
    }

    /// A fault in step `step` that leaves the demands sound: all robots stop on their paths for it. The first one is kept.
    pub fn protect(&mut self, fault: Fault, step: u64) {
        let process = self.process;
        self.protective.get_or_insert_with(|| fault.in_process(process).at_step(step));
    }

    /// The fault that an instruction ends with which met `fault`: what goes wrong while a protective stop is under way is not
    /// its cause.
    pub fn cause(&self, fault: Fault) -> Fault {
        match &self.protective {
            Some(protective) if precedes(protective, &fault) => protective.clone(),
            Some(_) | None => fault,
        }
    }

    /// What an instruction ends with in step `step` that the operator, a guard or a sensor ends on its path.
    pub fn ending(&self, step: u64) -> Fault {
        let fault = self.protective.clone().unwrap_or_else(|| Fault::orderly(FaultKind::Aborted));
        fault.in_process(self.process).at_step(step)
    }

    /// The protective stop that was to end on the path within so many steps, and has not in step `step`.
    pub fn overdue(&self, step: u64, most: u64) -> Option<Fault> {
        let protective = self.protective.as_ref()?;
        let began = protective.step().unwrap_or(step);
        (step > began + most).then(|| protective.clone().off_path())
    }

    /// Whether the guard is to look at the robots in this step.
    pub fn guard_is_due(&self, step: u64) -> bool {
        self.protective.is_none() && self.guard.as_ref().is_some_and(|guard| guard.is_due(step))
    }

    /// Shows the guard what the robots reported, and lets it look.
    pub fn let_guard_look(&mut self, robots: &RobotPorts, step: u64) {
        let Some(guard) = &mut self.guard else { return };
        for (i, robot) in robots.iter().enumerate() {
            if let Some(view) = robot.view() {
                guard.see(i, view);
            }
        }
        if self.protective.is_none() && guard.is_due(step) {
            self.protective = guard.look(step).err().map(|fault| fault.of_guard().at_step(step));
        }
    }

    /// Whether the guard has panicked, and does not look any more.
    pub fn guard_is_asleep(&self) -> bool {
        self.guard.as_ref().is_some_and(|guard| !guard.is_awake())
    }

    /// Ends a program that loops over refused instructions, through the process's own boundary.
    pub fn refuse(&mut self) {
        self.refusals += 1;
        if self.refusals > MAX_REFUSALS {
            self.refusals = 0;
            std::panic::resume_unwind(Box::new(Ended("ended by the runtime: it ignores a latched fault")));
        }
    }

    /// Forgets the causes, for a reset; a process that is gone stays gone.
    pub fn forget(&mut self) {
        self.latched = None;
        self.protective = None;
        self.refusals = 0;
        if let Some(guard) = &mut self.guard {
            guard.forget();
        }
    }
}

/// First cause: the lowest step, then the more severe; equals keep the place in the list.
pub(super) fn precedes(fault: &Fault, other: &Fault) -> bool {
    let key = |fault: &Fault| (fault.step().unwrap_or(u64::MAX), core::cmp::Reverse(fault.class()));
    key(fault) < key(other)
}
