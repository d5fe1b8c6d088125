//! What a cell does, as far as it matters to its operator.
//!
//! In: the operator's handle. Out: one of a few states, which decide what a request does.

use super::Operator;
use crate::safety::latch::Latch;

/// What a cell does, as far as it matters to its operator.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum CellState {
    /// No Move or Wait of the MP is at work.
    #[default]
    Idle,
    /// One is.
    Running,
    /// One stands, or is coming to a standstill, until the operator resumes it.
    Suspended,
    /// The operator ends one.
    Aborting,
    /// All robots stop for good.
    Stopping,
    /// They have, and the fault is latched.
    Latched,
    /// The operator has taken notice of it.
    Acknowledged,
    /// Robots are made ready to start again.
    Resetting,
}

impl CellState {
    /// All of them; one travels as its place in this list.
    pub const ALL: [CellState; 8] = [
        CellState::Idle,
        CellState::Running,
        CellState::Suspended,
        CellState::Aborting,
        CellState::Stopping,
        CellState::Latched,
        CellState::Acknowledged,
        CellState::Resetting,
    ];

    /// Their words, in the same order.
    const WORDS: [&str; 8] =
        ["idle", "running", "suspended", "aborting", "stopping", "latched", "acknowledged", "resetting"];

    /// Its word.
    pub const fn word(self) -> &'static str {
        CellState::WORDS[self as usize]
    }

    /// The one that travels as this; `None` if there is none.
    pub fn from_word(word: u64) -> Option<CellState> {
        CellState::ALL.get(usize::try_from(word).ok()?).copied()
    }
}

impl Operator {
    /// The state of a cell.
    pub fn state(&self) -> CellState {
        match self.latch() {
            Latch::Clear => {}
            Latch::Stopping => return CellState::Stopping,
            Latch::Latched => return CellState::Latched,
            Latch::Acknowledged => return CellState::Acknowledged,
            Latch::Resetting => return CellState::Resetting,
        }
        match (self.is_aborting(), self.is_suspended(), self.is_running()) {
            (true, ..) => CellState::Aborting,
            (_, true, _) => CellState::Suspended,
            (.., true) => CellState::Running,
            (.., false) => CellState::Idle,
        }
    }
}
