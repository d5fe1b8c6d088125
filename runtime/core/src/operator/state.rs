//! What the processes of a cell show of themselves to its operator, in plain numbers.

use crate::model::fault::FaultWords;
use crate::model::load::Load;
use crate::model::pose::Pose;
use crate::model::signals::Signals;
use crate::model::time::Nanos;
use crate::model::type_name::TypeName;

pub use crate::model::instruction::InstructionKind;

use super::button::{Button, Pressed};
use super::cell_state::CellState;
use super::jog::JogStop;

/// What an MP shows of itself in every step.
#[derive(Clone, Default)]
pub struct MpState {
    /// Index of the step.
    pub step: u64,
    /// Length of a step \[ns\].
    pub period: Nanos,
    /// The epoch: every reset begins another one.
    pub epoch: u32,
    /// Moves and Waits that the program has begun, since its first line.
    pub instructions: u64,
    /// What is done now.
    pub doing: InstructionKind,
    /// The generator or condition of the last instruction. An MP without a program of its own has none: it lets the
    /// programs of the ECPs run.
    pub by: TypeName,
    /// The rate of path time, 0 to 1.
    pub rate: f64,
    /// The speed that the operator set, 0 to 1.
    pub speed: f64,
    /// Whether the cell is at reduced speed.
    pub reduced: bool,
    /// Whether a person holds what lets its robots move then.
    pub held: bool,
    /// Which of its robots may be jogged now, by their places in the cell: a bit of each.
    pub jogs: [u64; 2],
    /// The place of the robot that is jogged by a program of the MP, and why that robot stands.
    pub jogged: Option<(u8, JogStop)>,
    /// The cell's state, as far as its operator is concerned.
    pub state: CellState,
    /// What became of the last press of each button.
    pub answers: [Pressed; Button::KINDS],
    /// What ended the last instruction that did not end well.
    pub fault: Option<FaultWords>,
    /// In a latched cell: what forbids a reset, or made the last one fail.
    pub persisting: Option<FaultWords>,
}

/// What the program of an ECP shows of its own instructions, whenever one begins or ends.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct EcpState {
    /// What is done now.
    pub doing: InstructionKind,
    /// The generator or condition of the last instruction.
    pub by: TypeName,
    /// Why its robot stands though it is jogged.
    pub stop: JogStop,
}

/// What an EDP shows of its robot beside the joints, whenever a step begins.
#[derive(Clone, Copy, Debug)]
pub struct EdpState<'a> {
    /// The tool in force, `X_FE` \[m\].
    pub tool: &'a Pose,
    /// What its drives were told last that the flange carries; `None`: they were told nothing.
    pub load: Option<&'a Load>,
    /// Its inputs and outputs.
    pub signals: &'a Signals,
}

/// What a VSP shows of its newest reading.
#[derive(Clone, Copy, Debug)]
pub struct VspState<'a> {
    /// The step in which it was taken.
    pub step: u64,
    /// Its words; `None`: there is a fault instead of a reading.
    pub words: Option<&'a [u64]>,
}
