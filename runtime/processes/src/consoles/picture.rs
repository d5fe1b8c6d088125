//! A picture of a running cell: the state that the operator is shown, and its form as text.
//!
//! In: a [`Picture`], or a line of text. Out: the text, or the picture again. The line is the word `picture` and the fields of the
//! picture by their names, as JSON.

use core::fmt;

use serde::{Deserialize, Serialize};

use super::as_words;
use super::beside::{BodyPicture, CarriedPicture, ReadingPicture};
use crate::board::figures::Figures;
use mrroc_core::operator::CellState;
use mrroc_core::operator::jog::JogStop;
use mrroc_core::operator::state::InstructionKind;
use mrroc_core::pose::Pose;

/// The state of a running cell.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Picture {
    /// Whether the MP is idle, runs an instruction, or is latched after a fault.
    #[serde(with = "as_words")]
    pub state: CellState,
    /// Index of the MP's step.
    pub step: u64,
    /// Period of the step \[ns\].
    pub period: u64,
    /// The epoch: every reset begins another one.
    pub epoch: u32,
    /// The rate of path time, 0 to 1.
    pub rate: f64,
    /// The speed that the operator has set, as a share of the planned speed, 0 to 1.
    pub speed: f64,
    /// Whether the cell is at reduced speed.
    pub reduced: bool,
    /// Whether a person holds what lets its robots move then.
    pub held: bool,
    /// Number of instructions begun.
    pub instructions: u64,
    /// The kind of the present instruction.
    #[serde(with = "as_words")]
    pub doing: InstructionKind,
    /// The name of the present instruction's generator or condition; empty where the MP has no program of its own and
    /// lets those of the ECPs run.
    pub by: String,
    /// The number of the process that holds the control token.
    pub holder: Option<u32>,
    /// The fault that ended the last instruction that failed.
    pub fault: Option<String>,
    /// What to do about it, where its kind alone tells.
    pub help: Option<String>,
    /// In a latched cell: what forbids a reset, or made the last one fail.
    pub persisting: Option<String>,
    /// Its lower cells, and theirs.
    pub cells: Vec<CellPicture>,
    /// The processes of the cell, in the order of their places.
    pub processes: Vec<ProcessPicture>,
    /// The robots of the cell.
    pub robots: Vec<RobotPicture>,
    /// What they carry, and their inputs and outputs.
    pub carried: Vec<CarriedPicture>,
    /// The newest readings of the virtual sensors.
    pub readings: Vec<ReadingPicture>,
    /// Where bodies are.
    pub bodies: Vec<BodyPicture>,
}

/// One lower cell.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct CellPicture {
    /// Its name: `press`, `line.press`.
    pub name: String,
    /// Whether its MP is idle, runs an instruction, or is latched after a fault.
    #[serde(with = "as_words")]
    pub state: CellState,
    /// Index of its MP's step.
    pub step: u64,
    /// Period of that step \[ns\].
    pub period: u64,
    /// The rate of its path time, 0 to 1.
    pub rate: f64,
    /// The speed that its own operator has set, as a share of the planned speed, 0 to 1.
    pub speed: f64,
    /// The kind of its present instruction.
    #[serde(with = "as_words")]
    pub doing: InstructionKind,
    /// The name of the present instruction's generator or condition.
    pub by: String,
    /// The fault that ended its last instruction that failed.
    pub fault: Option<String>,
}

/// One process of the cell.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ProcessPicture {
    /// Its role and robot or sensor, such as `ecp left`.
    pub name: String,
    /// Its number in the operating system.
    pub pid: u32,
    /// Whether it runs.
    pub runs: bool,
    /// How late it was and how long it worked.
    pub figures: Figures,
}

/// One robot of the cell.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RobotPicture {
    /// Its name.
    pub name: String,
    /// Time of the servo period that is shown \[s\].
    pub time: f64,
    /// Demanded joint positions, in the order of the joints [rad or m].
    #[serde(with = "as_words")]
    pub demanded: Vec<f64>,
    /// Measured joint positions, in the order of the joints [rad or m].
    #[serde(with = "as_words")]
    pub measured: Vec<f64>,
    /// The pose of its tool at the measured joints, `X_WE`; of a mounted robot, in the flange that carries it.
    #[serde(with = "as_words")]
    pub tool: Pose,
    /// What the program of its ECP does now.
    #[serde(with = "as_words")]
    pub doing: InstructionKind,
    /// The name of the generator or condition of that program's last instruction; empty before the first one, and where
    /// the ECP has no program of its own.
    pub by: String,
    /// Whether a program lets it be jogged now.
    pub jogs: bool,
    /// Why it stands though it is jogged.
    #[serde(with = "as_words")]
    pub stop: JogStop,
}

impl fmt::Display for Picture {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "picture {}", serde_json::to_string(self).map_err(|_| fmt::Error)?)
    }
}

impl Picture {
    /// Who carries out the present instruction, in words: its generator or condition, or the programs of the ECPs.
    #[must_use]
    pub fn by_whom(&self) -> &str {
        match self.doing {
            InstructionKind::Move if self.by.is_empty() => "of each robot by its own program",
            InstructionKind::Nothing
            | InstructionKind::Homing
            | InstructionKind::Move
            | InstructionKind::Wait => &self.by,
        }
    }
}

impl Picture {
    /// How its speed is reduced, in words that follow others; empty where it is not.
    #[must_use]
    pub const fn reduction(&self) -> &'static str {
        match (self.reduced, self.held) {
            (false, _) => "",
            (true, true) => ", reduced, held",
            (true, false) => ", reduced, nobody holds",
        }
    }
}

impl RobotPicture {
    /// What the program of its ECP does, in words that follow others: `: move Line`; empty where it does nothing, or is
    /// none.
    #[must_use]
    pub fn motion(&self) -> String {
        match self.doing {
            InstructionKind::Nothing => String::new(),
            InstructionKind::Homing | InstructionKind::Move | InstructionKind::Wait => {
                format!(": {} {}", self.doing.word(), self.by)
            }
        }
    }
}
