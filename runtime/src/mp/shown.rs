//! The MP and its operator: what it is told when a step begins, and what it shows of itself.
//!
//! In: the buttons that were pressed since the last step. Out: what became of each, and in which step; and plain numbers
//! of what the MP does, for whoever looks on from outside: nobody waits for that.

use crate::button::{Answer, Button, CellState};
use crate::fault::{Fault, FaultWords};
use crate::link::Nanos;

use super::Mp;

/// What kind of instruction an MP carries out.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Doing {
    /// None: its program computes, or is over.
    #[default]
    Nothing,
    /// The drives look for their reference marks.
    Homing,
    Move,
    Wait,
}

#[cfg(all(feature = "processes", target_os = "linux"))]
impl Doing {
    /// All of them; one travels as its place in this list.
    pub const ALL: [Doing; 4] = [Doing::Nothing, Doing::Homing, Doing::Move, Doing::Wait];

    /// Its word.
    pub const fn word(self) -> &'static str {
        match self {
            Doing::Nothing => "nothing",
            Doing::Homing => "homing",
            Doing::Move => "move",
            Doing::Wait => "wait",
        }
    }
}

/// What an MP shows of itself in every step.
#[derive(Clone, Default)]
pub(crate) struct MpState {
    /// Index of the step, and the length of one \[ns\].
    pub step: u64,
    pub period: Nanos,
    /// Instructions begun, what the last one is and by which generator or condition.
    pub instructions: u64,
    pub doing: Doing,
    pub by: &'static str,
    /// The rate of path time, 0 to 1, and the speed that the operator set.
    pub rate: f64,
    pub speed: f64,
    pub state: CellState,
    /// What became of the last press of each button.
    pub answers: [Answer; Button::KINDS],
    /// What ended the last instruction that did not end well.
    pub fault: Option<FaultWords>,
}

impl Mp<'_> {
    /// An instruction begins. Its generator or condition is named as the program names its type.
    pub(super) fn show_instruction(&mut self, doing: Doing, by: &'static str) {
        let shown = &mut self.shown;
        shown.instructions += 1;
        (shown.doing, shown.by) = (doing, by);
    }

    /// It is over.
    pub(super) fn show_end(&mut self) {
        self.shown.doing = Doing::Nothing;
        self.shown.state = self.state();
        self.waiter.show(&self.shown);
    }

    /// A step begins.
    pub(super) fn show_step(&mut self) {
        let state = self.state();
        let (shown, clock) = (&mut self.shown, &self.clock);
        (shown.step, shown.period) = (clock.step(), clock.period());
        (shown.rate, shown.speed, shown.state) = (clock.feed.rate(), self.operator.speed(), state);
        self.waiter.show(&self.shown);
    }

    /// Carries out what the operator has pressed, each kind at most once a step.
    pub(super) fn hear_operator(&mut self) {
        for kind in 0..Button::KINDS {
            if let Some((number, button)) = self.waiter.pressed(kind) {
                let state = self.state();
                let done = self.operator.press(button, state);
                self.shown.answers[kind] = Answer { number, step: self.clock.step(), state, done };
            }
        }
        if self.latched.is_none() && self.operator.take_protective_stop() {
            self.stopping = true;
            self.protect(Fault::of_operator());
        }
    }

    fn state(&self) -> CellState {
        if self.protective.is_some() && self.latched.is_none() {
            CellState::Stopping
        } else {
            self.operator.state()
        }
    }
}
