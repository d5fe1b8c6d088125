//! Who coordinates a cell: the MP's program, its operator, and what they do after a fault.

use crate::control::guard::Guard;
use crate::control::mp::{Mp, StepHook};
use crate::model::fault::Fault;
use crate::observe::activity::Activity;
use crate::observe::shown::Shown;
use crate::operator::Operator;
use crate::safety::latch::AfterFault;

/// A coordinating program.
pub(super) type MpProgram = Box<dyn FnMut(&mut Mp) -> Result<(), Fault>>;

/// The MP's side of a cell.
pub(super) struct Coordination {
    /// Without one the MP triggers.
    pub program: Option<MpProgram>,
    pub operator: Operator,
    /// What the program does, for observers.
    pub activity: Shown<Activity>,
    /// What is called at the start of every step.
    pub hook: Option<StepHook>,
    /// What looks at all robots.
    pub guard: Option<Guard>,
    pub after_fault: AfterFault,
}

impl Default for Coordination {
    fn default() -> Self {
        Coordination {
            program: None,
            operator: Operator::new(),
            activity: Shown::new(Activity::default()),
            hook: None,
            guard: None,
            after_fault: AfterFault::End,
        }
    }
}
