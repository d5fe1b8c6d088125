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

#[cfg(feature = "recording")]
mod channels;
#[cfg(feature = "recording")]
mod file;
#[cfg(feature = "recording")]
mod json;
#[cfg(feature = "recording")]
mod messages;
#[cfg(feature = "recording")]
mod reader;
#[cfg(all(feature = "recording", feature = "processes", target_os = "linux"))]
pub(crate) mod relay;
#[cfg(all(not(feature = "recording"), feature = "processes", target_os = "linux"))]
#[path = "no_relay.rs"]
pub(crate) mod relay;
#[cfg(feature = "recording")]
mod ring;
#[cfg(feature = "recording")]
mod running;
#[cfg(not(feature = "recording"))]
#[path = "without.rs"]
mod running;

use core::fmt;
use std::path::{Path, PathBuf};

use mrroc_core::cell::Layout;

#[cfg(feature = "recording")]
pub(crate) use reader::read_bytes;
#[cfg(feature = "recording")]
pub use reader::{CutOff, NotReplayable};
#[cfg(all(not(feature = "recording"), feature = "processes", target_os = "linux"))]
pub(crate) use relay::Pace;
#[cfg(all(feature = "recording", feature = "processes", target_os = "linux"))]
pub(crate) use ring::Pace;
#[cfg(feature = "recording")]
pub(crate) use ring::Recorder;
#[cfg(not(feature = "recording"))]
pub(crate) use running::Recorder;
#[cfg(feature = "recording")]
pub use running::ReplayError;
pub(crate) use running::begin;

/// Why a run is not recorded.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NotRecorded {
    /// The file cannot be written.
    #[error("{}: cannot be written: {error}\n help: give another file by --record", file.display())]
    Unwritable {
        /// The file.
        file: PathBuf,
        /// What the system says.
        error: String,
    },
    /// Of a robot or a sensor that is not there.
    #[error("the recording asks for {0} `{1}`, which the cell does not have\n help: the cell has: {2}")]
    NotThere(&'static str, String, String),
    /// The program was built without the feature.
    #[error(
        "this program was built without recording\n help: build it with mrroc's feature `recording`: cargo run --release --features mrroc/recording -- --record run.mcap"
    )]
    NoFeature,
}

/// What a run is recorded to, and what of it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Recording {
    pub(crate) file: PathBuf,
    pub(crate) robots: Option<Vec<String>>,
    pub(crate) sensors: Option<Vec<String>>,
}

impl Recording {
    /// Everything, to a file, which is made or written anew.
    pub fn to(file: impl Into<PathBuf>) -> Recording {
        Recording { file: file.into(), robots: None, sensors: None }
    }

    /// The same, to another file.
    pub(crate) fn into(self, file: &Path) -> Recording {
        Recording { file: file.to_owned(), ..self }
    }

    /// Of the robots only these. A recording without all robots cannot be replayed.
    #[must_use]
    pub fn robots<'a>(mut self, names: impl IntoIterator<Item = &'a str>) -> Recording {
        self.robots = Some(names.into_iter().map(str::to_owned).collect());
        self
    }

    /// Of the sensors only these. A recording without all sensors cannot be replayed.
    #[must_use]
    pub fn sensors<'a>(mut self, names: impl IntoIterator<Item = &'a str>) -> Recording {
        self.sensors = Some(names.into_iter().map(str::to_owned).collect());
        self
    }

    /// Of a cell, what it is asked to record.
    #[cfg(feature = "recording")]
    fn of(&self, mut layout: Layout) -> Layout {
        let asked = |names: &Option<Vec<String>>, name: &String| {
            names.as_ref().is_none_or(|names| names.contains(name))
        };
        layout.robots.retain(|robot| asked(&self.robots, &robot.name));
        layout.sensors.retain(|sensor| asked(&self.sensors, &sensor.name));
        layout
    }

    /// What it asks for and the cell does not have.
    pub(crate) fn check(&self, layout: &Layout) -> Vec<NotRecorded> {
        let robots: Vec<_> = layout.robots.iter().map(|robot| robot.name.clone()).collect();
        let sensors: Vec<_> = layout.sensors.iter().map(|sensor| sensor.name.clone()).collect();
        let asked = [("robot", &self.robots, robots), ("sensor", &self.sensors, sensors)];
        let missing = asked.iter().flat_map(|(what, names, there)| {
            let names = names.iter().flatten().filter(|name| !there.contains(name));
            names.map(|name| NotRecorded::NotThere(what, name.clone(), there.join(", ")))
        });
        missing.collect()
    }
}

impl fmt::Display for Recording {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.file.display())?;
        for (what, names) in [("robots", &self.robots), ("sensors", &self.sensors)] {
            if let Some(names) = names {
                write!(f, ", {what} {}", if names.is_empty() { "none".to_owned() } else { names.join(" ") })?;
            }
        }
        Ok(())
    }
}
