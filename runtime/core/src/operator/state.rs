//! What an MP shows of itself to its operator in every step, in plain numbers.

use crate::model::fault::FaultWords;
use crate::model::time::Nanos;

use super::button::{Answer, Button, CellState};

/// What kind of instruction an MP carries out.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Doing {
    /// None: its program computes, or is over.
    #[default]
    Nothing,
    /// The drives look for their reference marks.
    Homing,
    Move,
    Wait,
}

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
pub struct MpState {
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
