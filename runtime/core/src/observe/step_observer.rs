//! What happens in the processes of a cell, shown to those who watch a run: a recording, a dry run, a replay.
//!
//! In: every step, order, image, reading and fault, from the process that has it. Out: nothing that a process acts on,
//! but for one word: the run is [over](StepObserver::is_over). A run that nobody watches pays a branch.

use std::rc::Rc;
use std::sync::Arc;

use crate::model::fault::{Fault, FaultWords, ProcessId};
pub use crate::model::image::STATE_WORDS;
pub use crate::model::signals::SIGNAL_WORDS;
use crate::model::time::Nanos;
use crate::model::wire::Wire;
pub use crate::observe::step_event::{IMAGE_WORDS, Mode, ReadingState, StepEvent, StepRecord};

/// Who watches.
pub trait StepObserver {
    /// A process shows something at a time of the cell.
    fn see(&self, time: Nanos, by: ProcessId, what: &StepEvent, words: &[u64]);

    /// Whether the cell is to end before this step.
    fn is_over(&self, _step: u64) -> bool {
        false
    }
}

/// An observer that may be on another thread than the steps.
pub type SharedStepObserver = Arc<dyn StepObserver + Send + Sync>;

impl StepObserver for SharedStepObserver {
    fn see(&self, time: Nanos, by: ProcessId, what: &StepEvent, words: &[u64]) {
        (**self).see(time, by, what, words);
    }

    fn is_over(&self, step: u64) -> bool {
        (**self).is_over(step)
    }
}

/// Where a process shows what happens in it.
#[derive(Clone)]
pub struct StepObservers {
    process: ProcessId,
    observers: Rc<[Rc<dyn StepObserver>]>,
}

impl StepObservers {
    /// Shown to these.
    pub fn to(observers: Vec<Rc<dyn StepObserver>>) -> StepObservers {
        StepObservers { process: ProcessId::MP, observers: observers.into() }
    }

    /// The same for another process.
    pub fn of(&self, process: ProcessId) -> StepObservers {
        StepObservers { process, observers: Rc::clone(&self.observers) }
    }

    /// Whether anybody watches.
    pub fn is_watched(&self) -> bool {
        !self.observers.is_empty()
    }

    /// Shows something.
    pub fn show(&self, time: Nanos, what: &StepEvent, words: &[u64]) {
        self.observers.iter().for_each(|observer| observer.see(time, self.process, what, words));
    }

    /// Shows something that is told in the words of a fault, if there is one.
    pub fn show_fault(&self, time: Nanos, what: &StepEvent, fault: Option<&Fault>) {
        let mut words = [0; FaultWords::LEN];
        let len = fault.map_or(0, |fault| {
            FaultWords::from(fault).put(&mut words);
            FaultWords::LEN
        });
        self.show(time, what, &words[..len]);
    }

    /// Whether the cell is to end before this step.
    pub fn is_over(&self, step: u64) -> bool {
        self.observers.iter().any(|observer| observer.is_over(step))
    }
}
