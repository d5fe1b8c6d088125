//! Recording: writes every step of a cell to an MCAP file, from a thread that may lag or block without delaying the
//! step.
//!
//! In: what the processes of a run show ([`step_observer`](mrroc_core::observe::step_observer)). Out: a file that common viewers
//! open, with a JSON schema for each channel; log time is the date of the run's start plus the cell's time \[ns\]. Back in:
//! such a file. Out: the comparison of a replay with it.
//!
//! | channel | what | schema |
//! |---|---|---|
//! | `/steps` | each step of the MP: path time, real time, what the operator wants | `mrroc.Step` |
//! | `/instructions` | Moves and Waits of the MP and of ECPs' programs as they begin and end: which process, its generator or condition | `mrroc.Instruction` |
//! | `/robots/NAME` | each step of the robot: demanded and measured joints, velocities, tool poses `X_WE`, the tool `X_FE` | `mrroc.RobotImage` |
//! | `/robots/NAME/currents` | the currents of its motors, where drives measure them | `mrroc.MotorCurrents` |
//! | `/robots/NAME/signals` | what its inputs read and its outputs are, by their names, where it has such | `mrroc.Signals.NAME` |
//! | `/robots/NAME/orders` | orders of the MP without a payload: queries, starts, ends | `mrroc.Order` |
//! | `/robots/NAME/orders/PAYLOAD` | orders with one, its fields by their names | `mrroc.Order.PAYLOAD` |
//! | `/sensors/NAME` | each reading that a process collected, its fields by their names | `mrroc.Reading.NAME` |
//! | `/bodies/NAME` | poses of bodies that the cell shows | `mrroc.Body` |
//! | `/commands` | what consoles asked of a cell of processes: who, when it was heard and when it was answered, the answer | `mrroc.Command` |
//! | `/events` | faults, aborts, what came too late for its step, values that programs recorded, the end | `mrroc.Event` |
//! | `/obstacles` | what stands in the cell, once | `foxglove.SceneUpdate` |
//! | `/tf`, `/scene` | frames of links and tools, shapes of links, bodies (`scene`) | `foxglove.FrameTransforms`, `foxglove.SceneUpdate` |
//!
//! Of a lower cell in a cell of cells `/steps`, `/instructions`, `/commands` and `/events` are `/cells/NAME/steps` and so on; its robots and sensors have
//! their names in the uppermost cell, `/robots/press.arm`.
//!
//! The file's metadata `mrroc` says what the cell is made of; `mrroc.start` the date at which it began; `mrroc.end`
//! how many messages there are and how many records were dropped. A step copies what it shows into a ring (`ring`). A thread makes messages of these records
//! (`channels`, `json`) and writes them to the file ([`file`]), or sends them to the launcher's thread when the
//! cell runs as processes (`relay`). When the ring is full, a step in real time drops the record and counts it. Under
//! the virtual clock, which stands still meanwhile, the step waits as long as the thread makes progress. `reader`
//! reads a file back.
//!
//! Images and echoes that sensors hand over are no messages of this file: each sensor's own process writes them to a file of
//! its own beside it (`frames`).
//!
//! JSON cannot express numbers that are not finite: they are written as the texts "NaN", "Infinity" and "-Infinity", as
//! in the JSON form of protocol buffers. Any other number is written with enough digits to be read back to the bit.

mod channels;
mod commands;
mod compare;
mod entity;
mod file;
mod foxglove;
mod frames;
mod json;
mod messages;
mod obstacles;
mod reader;
mod recorder;
mod records;
mod relay;
mod replaying;
mod ring;
mod samples;
mod scene;
mod wrong;

use std::path::PathBuf;

use mrroc_core::observe::recording::Recording;

pub use compare::{Compared, Difference};
pub use json::{as_number, json_of};
pub use reader::{Completeness, McapMessage, each_mcap_message, each_message_of};
pub use recorder::Mcap;
pub use replaying::{Replay, ReplayError, replay_command};
pub use samples::{RecordedMessage, RobotSample, Sample, StateSample};
pub use wrong::{CutOff, NotReplayable};

/// Records everything to the MCAP file at `file`, which is created; a recording that is there is overwritten, any other file
/// is refused. An argument for
/// [`Cell::record`](mrroc_core::cell::Cell::record).
pub fn to(file: impl Into<PathBuf>) -> Recording {
    Recording::to(file).by(&Mcap)
}

/// Reads a recording of this cell, for fuzzing. Not part of the stable interface.
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
