//! What happens in the processes of a cell, shown to those who watch a run: a recording, a dry run, a replay.
//!
//! In: every step, order, image, reading and fault, from the process that has it. Out: nothing that a process acts on,
//! but for one word: the run is [over](StepObserver::is_over). A run that nobody watches pays a branch.

use std::rc::Rc;
use std::sync::Arc;

use crate::link::message::OrderKind;
use crate::model::fault::{Fault, FaultWords, ProcessId};
pub use crate::model::image::STATE_WORDS;
use crate::model::name::Name;
use crate::model::shape::Shape;
pub use crate::model::signals::SIGNAL_WORDS;
use crate::model::time::Nanos;
use crate::model::type_name::TypeName;
use crate::model::wire::Wire;
use crate::operator::state::InstructionKind;

/// Words of what an image is shown as: the demanded state, the measured one, the tool.
pub const IMAGE_WORDS: usize = 2 * STATE_WORDS + 7;

/// What happened. The words that are shown beside it are named with each.
#[derive(Clone, Copy, Debug)]
pub enum StepEvent {
    /// The MP begins a step. No words.
    Step {
        /// Its index.
        step: u64,
        /// Its path time \[s\].
        dt: f64,
        /// Its real time \[s\].
        duration: f64,
        /// The speed that the operator wants, as a share of the plan, 0 to 1.
        speed: f64,
        /// Whether the operator has suspended the cell.
        suspended: bool,
        /// Whether the limit of reduced speed is in force.
        reduced: bool,
        /// Whether the operator aborts.
        aborting: bool,
        /// Whether the operator has asked for a protective stop since the step before.
        stopping: bool,
        /// Whether the operator has reset the latched cell.
        resetting: bool,
    },
    /// An instruction begins, or is over: of the MP's program, or of the program of an ECP. No words.
    Instruction {
        /// The last step that began before.
        step: u64,
        /// What is done from now on; [`InstructionKind::Nothing`]: the last instruction is over.
        doing: InstructionKind,
        /// Its generator or condition; [`TypeName::NONE`] of homing, and of an MP without a program, which lets those of the
        /// ECPs run.
        by: TypeName,
    },
    /// The operator aborts, after the step began. No words.
    Abort {
        /// The step.
        step: u64,
    },
    /// From this step on, this is asked of the robot that a person jogs: the words of a
    /// [`JogNow`](crate::operator::jog::JogNow).
    Jog {
        /// The step.
        step: u64,
        /// The robot.
        robot: Name,
    },
    /// What took place in the step left no time for more: an MP or ECP could not begin a motion in it. No words.
    Late {
        /// The step.
        step: u64,
    },
    /// A request came too late to its EDP for its step. No words.
    LateRequest {
        /// The step.
        step: u64,
        /// Its place among the requests of that step, from 0.
        nth: u32,
        /// The step for which demands could be taken when it came.
        due: u64,
    },
    /// The MP orders; the words of the order, if it has one.
    Order {
        /// The robot that is ordered.
        robot: Name,
        /// The step.
        step: u64,
        /// The ordinal of the instruction.
        instruction: u32,
        /// What kind of order it is.
        kind: OrderKind,
        /// The name of the order's type.
        payload: &'static str,
        /// What its words say.
        shape: &'static Shape,
    },
    /// The drives of an EDP have found their reference marks. No words.
    Found {
        /// The step.
        step: u64,
    },
    /// An EDP begins a step: [`IMAGE_WORDS`] words.
    Image {
        /// The step.
        step: u64,
        /// What the robot does in it.
        mode: Mode,
    },
    /// What the motors of a robot take when an EDP begins a step: a word for each motor, its current \[A\].
    Currents {
        /// The step.
        step: u64,
    },
    /// The inputs and outputs of a robot that has such, when an EDP begins a step: [`SIGNAL_WORDS`] words of its
    /// [`Signals`](crate::robot::Signals).
    Signals {
        /// The step.
        step: u64,
    },
    /// A process has collected a reading: its words, or those of a fault.
    Reading {
        /// The sensor.
        sensor: Name,
        /// The step in which it was collected.
        step: u64,
        /// What was collected.
        state: ReadingState,
        /// The step in which it was taken.
        taken: u64,
        /// What its words say.
        shape: &'static Shape,
    },
    /// A process stops for a fault: its words.
    Fault {
        /// The step.
        step: u64,
    },
    /// Where a body is that the robots handle: the words of its pose `X_WB`.
    Body {
        /// The step.
        step: u64,
        /// The body, one of the [layout](crate::observe::layout::Layout::bodies).
        body: Name,
    },
    /// The MP's program is over: no words, or those of the fault it ended with.
    End {
        /// The last step.
        step: u64,
    },
}

/// What an EDP does in a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mode {
    /// The robot stands where it was demanded last.
    Holding,
    /// It follows its demands.
    Moving,
    /// The demand did not come: the path goes on.
    Bridging,
    /// It is on its way to a standstill.
    Braking,
    /// Its drives have no power.
    Off,
}

/// What a process has collected.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ReadingState {
    /// A reading.
    There,
    /// Nothing yet.
    None,
    /// The sensor's fault.
    Fault,
    /// No answer in time.
    Lost,
}

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
