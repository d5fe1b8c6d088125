//! The MP and its operator: what it is told when a step begins, and what it shows of itself.
//!
//! In: the buttons that were pressed since the last step. Out: what became of each, and in which step; and plain numbers
//! of what the MP does, for an operator's panel outside of the cell: the MP does not wait for it.

use crate::model::fault::{Fault, FaultWords};
use crate::model::instruction::{Instruction, Level};
use crate::model::time::Nanos;
use crate::model::type_name::TypeName;
use crate::observe::activity::Activity;
use crate::observe::shown::Shown;
use crate::operator::button::{Button, Pressed};
use crate::operator::console::Console;
use crate::operator::hold::Hold;
use crate::operator::jog::{JogRefusal, JogStop};
use crate::operator::state::{InstructionKind, MpState};
use crate::operator::{CellState, Operator};

use super::clock::StepClock;

/// What is called at the start of every step: the cell's index of the step and its operator.
pub(crate) type StepHook = Box<dyn FnMut(u64, &Operator)>;

/// The operator's side of the MP.
pub(super) struct Operating {
    pub operator: Operator,
    hook: Option<StepHook>,
    /// Whether the operator has asked for a protective stop since the step before.
    pub stopping: bool,
    /// Whether the limit of reduced speed is in force.
    pub is_slow: bool,
    hold: Hold,
    /// Whether the operator was seen to abort in this step.
    pub aborts: bool,
    /// What an operator is shown.
    shown: MpState,
    /// What observers are shown.
    pub activity: Shown<Activity>,
}

impl Operating {
    pub fn new(operator: Operator, hook: Option<StepHook>, activity: Shown<Activity>) -> Self {
        // From now on this process says what it is.
        activity.set(Activity::default());
        Operating {
            operator,
            hook,
            stopping: false,
            is_slow: false,
            hold: Hold::default(),
            aborts: false,
            shown: MpState::default(),
            activity,
        }
    }

    /// Calls the hook of a step that begins. One that panics is not called again by the stop that follows.
    pub fn call_hook(&mut self, step: u64) {
        if let Some(mut hook) = self.hook.take() {
            hook(step, &self.operator);
            self.hook = Some(hook);
        }
    }

    /// The program begins at its first line: its instructions are counted from there.
    pub fn count_from_here(&mut self) {
        self.shown.instructions = 0;
    }

    /// An instruction begins, of this generator or condition.
    pub fn show_instruction(&mut self, doing: InstructionKind, by: TypeName) {
        self.shown.instructions += u64::from(doing != InstructionKind::Homing);
        self.shown.doing = doing;
        self.shown.by = by;
    }

    /// The instruction that is at work, as a fault names it. An MP without a program of its own has none to name.
    pub fn instruction(&self) -> Option<Instruction> {
        let MpState { instructions, doing, by, .. } = self.shown;
        let is_own = by != TypeName::NONE || doing == InstructionKind::Homing;
        is_own.then(|| Instruction::new(instructions, doing, Level::Mp, by)).flatten()
    }

    /// An instruction has ended with a fault, or the cell has stopped for one.
    pub fn show_fault(&mut self, fault: &Fault) {
        self.shown.fault = Some(FaultWords::from(fault));
    }

    /// In a latched cell: what forbids a reset, or made the last one fail.
    pub fn show_persisting(&mut self, persisting: Option<&Fault>) {
        self.shown.persisting = persisting.map(FaultWords::from);
        self.operator.show_persisting(persisting.cloned());
    }

    /// Shows observers that the operator has suspended the cell, or has resumed it.
    pub fn show_suspension(&self) {
        let (mut activity, suspended) = (self.activity.get(), self.operator.is_suspended());
        if activity.suspended != suspended {
            activity.suspended = suspended;
            self.activity.set(activity);
        }
    }

    /// An instruction is over.
    pub fn show_end(&mut self, state: CellState, console: &dyn Console) {
        self.shown.doing = InstructionKind::Nothing;
        self.shown.state = state;
        console.show(&self.shown);
    }

    /// A step begins.
    pub fn show_step(&mut self, state: CellState, epoch: u32, clock: &StepClock, console: &dyn Console) {
        let shown = &mut self.shown;
        shown.epoch = epoch;
        shown.step = clock.step();
        shown.period = clock.period();
        shown.rate = clock.feed.rate();
        shown.speed = self.operator.speed();
        (shown.reduced, shown.held) = (self.operator.is_reduced(), self.operator.is_held());
        shown.state = state;
        console.show(shown);
    }

    /// Carries out a button of a kind that the operator has pressed under a number, in a state of the cell, in a step.
    /// What is `refused` is not.
    pub fn press(
        &mut self,
        step: u64,
        (kind, number, button): (usize, u64, Button),
        state: CellState,
        refused: Option<JogRefusal>,
    ) {
        let done = refused.is_none() && self.operator.press(button, state);
        self.shown.answers[kind] = Pressed { number, step, state, done, why: refused };
    }

    /// The number of the hold that lasts at `now`, if one does and the limit of reduced speed is in force. That comes into force
    /// at a standstill on the path, so that no motion is refused that was faster when it was asked for; a hold counts from then on.
    pub fn lasting_hold(&mut self, now: Nanos, stands: bool) -> Option<u64> {
        let lasting = self.operator.lasting_hold(&mut self.hold, now);
        self.is_slow = self.operator.is_reduced() && (self.is_slow || stands || !self.operator.is_running());
        lasting.filter(|_| self.is_slow)
    }

    /// A hold lasts that counts, or none does.
    pub fn show_held(&self, held: bool) {
        self.operator.show_held(held);
    }

    /// Whether this is what is done now.
    pub fn is_doing(&self, doing: InstructionKind) -> bool {
        self.shown.doing == doing
    }

    /// Which robots may be jogged now, and why one stands.
    pub const fn show_jogs(&mut self, (jogs, jogged): ([u64; 2], Option<(u8, JogStop)>)) {
        (self.shown.jogs, self.shown.jogged) = (jogs, jogged);
    }

    /// The same in a replay, which knows from the recording what was suspended and what was in force.
    pub fn replay_hold(&mut self) {
        self.operator.show_held(true);
        self.is_slow = self.operator.is_reduced();
    }

    /// Takes the protective stop that the operator has asked for.
    pub fn take_protective_stop(&mut self) -> bool {
        let asked = self.operator.take_protective_stop();
        // Not `|=`: rustc 1.95 would set it whatever was asked (decision 24).
        if asked {
            self.stopping = true;
        }
        asked
    }
}
