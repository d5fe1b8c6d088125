//! The MP and its operator: what it is told when a step begins, and what it shows of itself.
//!
//! In: the buttons that were pressed since the last step. Out: what became of each, and in which step; and plain numbers
//! of what the MP does, for whoever looks on from outside: nobody waits for that.

use crate::model::fault::Fault;
use crate::operator::button::{Answer, Button, CellState};
use crate::operator::state::Doing;

use super::Mp;

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
        self.host.console.show(&self.shown);
    }

    /// A step begins.
    pub(super) fn show_step(&mut self) {
        let state = self.state();
        let (shown, clock) = (&mut self.shown, &self.clock);
        (shown.step, shown.period) = (clock.step(), clock.period());
        (shown.rate, shown.speed, shown.state) = (clock.feed.rate(), self.operator.speed(), state);
        self.host.console.show(&self.shown);
    }

    /// Carries out what the operator has pressed, each kind at most once a step.
    pub(super) fn hear_operator(&mut self) {
        for kind in 0..Button::KINDS {
            if let Some((number, button)) = self.host.console.pressed(kind) {
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
