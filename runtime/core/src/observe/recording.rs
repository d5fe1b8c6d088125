//! A recording, as a cell is asked for one: to which file, and what of the cell. What writes it is a crate of its own, a
//! [`Recorder`].

use core::fmt;
use core::time::Duration;
use std::any::Any;
use std::path::{Path, PathBuf};
use std::rc::Rc;

use crate::model::fault::ProcessId;
use crate::model::frames::FrameSink;
use crate::model::name::Name;
use crate::model::time::{Clock, Nanos};
use crate::observe::layout::Layout;
use crate::observe::step_observer::StepObserver;

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
    /// The file is one that the run reads.
    #[error("{0}")]
    Overwrites(String),
    /// Of a robot or a sensor that is not there.
    #[error("the recording asks for {0} `{1}`, which the cell does not have\n help: the cell has: {2}")]
    NotThere(&'static str, String, String),
    /// The frames of a sensor have no thread that writes them.
    #[error("the frames of sensor `{0}` are not recorded: {1}")]
    Frames(String, String),
    /// The program was built without the crate that records.
    #[error(
        "this program was built without recording\n help: build it with mrroc's feature `recording`: cargo run --release --features mrroc/recording -- --record run.mcap"
    )]
    NoFeature,
}

/// Writes recordings.
pub trait Recorder: fmt::Debug + Sync {
    /// Begins to record a run in this process.
    ///
    /// # Errors
    /// [`NotRecorded`]: the file cannot be written.
    fn begin(&self, recording: &Recording, layout: &Layout) -> Result<Rc<dyn RunRecord>, NotRecorded>;

    /// In the launcher of a cell of processes: waits for what they record, until what it returns is dropped. `folder` is
    /// the session's.
    ///
    /// # Errors
    /// [`NotRecorded`]: the file cannot be written.
    fn listen(
        &self,
        recording: &Recording,
        layout: &Layout,
        folder: &Path,
        clock: Clock,
    ) -> Result<Box<dyn Any>, NotRecorded>;

    /// In a process of such a cell: hands what it has to the launcher, if the session of this folder is recorded and the
    /// process has anything to show. A process that cannot says so and runs all the same.
    fn join(
        &self,
        recording: Option<&Recording>,
        layout: &Layout,
        process: ProcessId,
        folder: &Path,
    ) -> Option<Rc<dyn RunRecord>>;

    /// In the launcher of a cell of processes: where it writes what consoles ask of the cell, if the session of this folder is
    /// recorded.
    fn commands(&self, folder: &Path, clock: Clock) -> Option<Box<dyn CommandRecord>>;

    /// What writes the frames of a sensor. Nothing is opened before the first frame.
    fn frames(&self, to: &FramesTo, sensor: &str) -> Box<dyn FrameSink>;
}

/// What a console has asked of a cell, and what it was answered.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Command {
    /// When it was heard, by the console server or by the panel's own server: a time of the cell \[ns\].
    pub asked: Nanos,
    /// When it was answered \[ns\].
    pub answered: Nanos,
    /// Who asked: `process 4711`, or `page 3 of process 4711`.
    pub by: String,
    /// The lower cell that was asked; the uppermost one if none.
    pub cell: Option<Name>,
    /// What was asked for, as a console writes it: `let-go 4711`.
    pub command: String,
    /// `done`, `refused`, `pending`; `unanswered` where the console was gone before.
    pub outcome: &'static str,
    /// The answer in words, with the step: `let go: step 1203`.
    pub answer: String,
}

/// Where a launcher writes what consoles ask of its cell.
pub trait CommandRecord: Send {
    /// Writes a command. It does not wait: what the recording cannot take is lost, and counted.
    fn put(&self, command: Command);
}

/// Where the frames of sensors go: images and echoes.
#[derive(Clone, Debug, Default)]
pub struct FramesTo {
    /// Beside this recording, in a file of the sensor's own, if it is to have the sensor.
    pub recording: Option<Recording>,
    /// As PNG files, in a folder of the sensor's own in this one.
    pub folder: Option<PathBuf>,
    /// The length of a step.
    pub step: Duration,
}

/// A run that is being recorded.
pub trait RunRecord: StepObserver {
    /// Writes what is not written yet: the run is over.
    fn finish(&self);
}

/// What a run is recorded to, and what of it.
#[derive(Clone, Debug)]
pub struct Recording {
    file: PathBuf,
    robots: Option<Vec<String>>,
    sensors: Option<Vec<String>>,
    recorder: Option<&'static dyn Recorder>,
}

impl Recording {
    /// Everything, to a file, which is made; a recording that is there is written anew, and any other file refused.
    pub fn to(file: impl Into<PathBuf>) -> Recording {
        Recording { file: file.into(), robots: None, sensors: None, recorder: None }
    }

    /// Written by this recorder.
    #[must_use]
    pub fn by(self, recorder: &'static dyn Recorder) -> Recording {
        Recording { recorder: Some(recorder), ..self }
    }

    /// The same, to another file.
    #[must_use]
    pub fn with_file(self, file: &Path) -> Recording {
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

    /// The file.
    #[must_use]
    pub fn file(&self) -> &Path {
        &self.file
    }

    /// What writes it.
    #[must_use]
    pub fn recorder(&self) -> Option<&'static dyn Recorder> {
        self.recorder
    }

    /// Whether it is to have the robot of this name.
    #[must_use]
    pub fn has_robot(&self, name: &str) -> bool {
        self.robots.as_ref().is_none_or(|names| names.iter().any(|known| known == name))
    }

    /// Whether it is to have the sensor of this name.
    #[must_use]
    pub fn has_sensor(&self, name: &str) -> bool {
        self.sensors.as_ref().is_none_or(|names| names.iter().any(|known| known == name))
    }

    /// Whether it is to have the sensor of this name in a lower cell.
    #[must_use]
    pub fn has_sensor_in(&self, cell: Option<&str>, name: &str) -> bool {
        let Some(cell) = cell else { return self.has_sensor(name) };
        let is_it = |known: &String| {
            known.strip_prefix(cell).and_then(|rest| rest.strip_prefix('.')).is_some_and(|rest| rest == name)
        };
        self.sensors.as_ref().is_none_or(|names| names.iter().any(is_it))
    }

    /// Of a cell, what it is asked to record.
    #[must_use]
    pub fn of(&self, mut layout: Layout) -> Layout {
        layout.robots.retain(|robot| self.has_robot(&robot.name));
        layout.sensors.retain(|sensor| self.has_sensor(&sensor.name));
        layout
    }

    /// What it asks for and the cell does not have.
    #[must_use]
    pub fn check(&self, layout: &Layout) -> Vec<NotRecorded> {
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
