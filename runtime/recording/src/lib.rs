//! Recording: every step of a cell to an MCAP file, from a thread that may lag or block, never the step.
//!
//! In: what the processes of a run show ([`witness`](mrroc_core::observe::witness)). Out: a file that common viewers open, with a JSON
//! schema for each channel; log time is the cell's time \[ns\].
//!
//! | channel | what | schema |
//! |---|---|---|
//! | `/steps` | each step of the MP: path time, real time, what the operator wants | `mrroc.Step` |
//! | `/robots/NAME` | each step of the robot: demanded and measured joints, velocities, tool poses `X_WE`, the tool `X_FE` | `mrroc.RobotImage` |
//! | `/robots/NAME/orders` | orders of the MP without a payload: queries, starts, ends | `mrroc.Order` |
//! | `/robots/NAME/orders/PAYLOAD` | orders with one, its fields by their names | `mrroc.Order.PAYLOAD` |
//! | `/sensors/NAME` | each reading that a process collected, its fields by their names | `mrroc.Reading.NAME` |
//! | `/events` | faults, aborts, what came too late for its step, the end | `mrroc.Event` |
//!
//! The file's metadata `mrroc` says what the cell is made of, `mrroc.end` how many messages there are and how many were
//! dropped. A step copies what it shows into a ring ([`ring`]); a thread makes messages of it ([`channels`], [`json`]) and
//! writes them to the file ([`file`]), or hands them to the launcher's thread when the cell runs as processes
//! (`relay`). Where the ring is full, a step in real time drops and counts; under the virtual clock, where time stands
//! still meanwhile, it waits for as long as the thread gets on. [`reader`] reads a file back.
//!
//! JSON has no words for numbers that are not finite: they are the texts "NaN", "Infinity", "-Infinity", as in the JSON
//! form of protocol buffers. Any other number is written with the digits that give it back to the bit.

mod channels;
mod compare;
mod file;
mod json;
mod messages;
mod reader;
mod recorder;
mod relay;
mod replaying;
mod ring;

use std::path::PathBuf;

use mrroc_core::observe::recording::Recording;

pub use compare::{Compared, Difference};
pub use reader::{CutOff, NotReplayable};
pub use recorder::Mcap;
pub use replaying::{Replay, ReplayError, replay_command};

/// Everything, to an MCAP file, which is made or written anew: for [`Cell::record`](mrroc_core::cell::Cell::record).
pub fn to(file: impl Into<PathBuf>) -> Recording {
    Recording::to(file).by(&Mcap)
}

/// Reads a recording of this cell, for fuzzing. Nothing here is promised to stay.
///
/// # Errors
/// What is wrong with it.
#[doc(hidden)]
pub fn read_bytes(cell: &mrroc_core::cell::Cell, bytes: &[u8]) -> Result<(), String> {
    let layout = cell.layout();
    let read =
        |cut_off| reader::read_bytes(bytes, &layout, cut_off).map(drop).map_err(|wrong| wrong.to_string());
    read(CutOff::Taken).and_then(|()| read(CutOff::Refused))
}
