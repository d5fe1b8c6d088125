//! A replay: a recording is fed back on the memory link, and the demands are compared with the recorded ones.
//!
//! In: a [`RecordedRun`], what a recording holds of what came from outside: the encoders' values, the sensors' readings, what programs recorded, the
//! operator's wishes, the steps in which the MP began and those whose demands came too late. Out: the same programs, which
//! see the same; and the first step, robot and joint whose demand differs, if any does ([`compare`]).

pub mod drives;
pub mod readings;
pub mod script;
pub mod values;

use std::collections::BTreeSet;
use std::rc::Rc;

use crate::model::driver::Measured;
use crate::model::fault::ProcessId;
use crate::model::joints::MAX_JOINTS;
use crate::model::name::Name;
use crate::model::signals::Signals;
use crate::model::time::Nanos;

pub use readings::RecordedReadings;
pub use script::Script;
pub use values::{RecordedValue, RecordedValues};

/// One step of a robot, as its EDP saw it begin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RecordedImage {
    /// Joint positions that were demanded [rad or m].
    pub demanded: [f64; MAX_JOINTS],
    /// What the encoders had read before [rad or m], [rad/s or m/s].
    pub measured: Measured<[f64; MAX_JOINTS]>,
}

/// A request that came too late for its step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LateRequest {
    /// The step.
    pub step: u64,
    /// Its place among the requests of that step, from 0.
    pub nth: u32,
    /// The step for which demands could be taken when it came.
    pub due: u64,
}

/// The steps of one robot, without a gap.
#[derive(Clone, Debug, PartialEq)]
pub struct RecordedRobot {
    /// Its name.
    pub name: Name,
    /// How many joints it has: entries of its images beyond them are 0.
    pub joints: usize,
    /// When its drives were found, if they had to look for their reference marks \[ns\].
    pub found: Option<Nanos>,
    /// The step of the first image.
    pub first: u64,
    /// Its images, one per step.
    pub images: Vec<RecordedImage>,
    /// The steps in which its inputs and outputs were other ones than before, and what they were then.
    pub signals: Vec<(u64, Signals)>,
    /// The requests that came too late to its EDP, in the order of their steps.
    pub late: Vec<LateRequest>,
    /// Steps in which its ECP found no time to begin a motion.
    pub put_off: BTreeSet<u64>,
    /// What the program of its ECP recorded.
    pub values: RecordedValues,
}

impl RecordedRobot {
    /// The image of a step, if it is recorded.
    pub fn image(&self, step: u64) -> Option<&RecordedImage> {
        self.images.get(usize::try_from(step.checked_sub(self.first)?).ok()?)
    }

    /// The image of a step, or the nearest one that is recorded.
    pub fn nearest(&self, step: u64) -> Option<&RecordedImage> {
        let last = (self.first + self.images.len() as u64).checked_sub(1)?;
        self.image(step.clamp(self.first, last))
    }

    /// Its inputs and outputs in a step: off before the first that is recorded.
    pub fn signals(&self, step: u64) -> Signals {
        let until = self.signals.partition_point(|&(changed, _)| changed <= step);
        until.checked_sub(1).map_or(Signals::OFF, |last| self.signals[last].1)
    }

    /// The step for which demands could be taken when this request came, if it came too late.
    pub fn came_late(&self, step: u64, nth: u32) -> Option<u64> {
        let found = self.late.binary_search_by_key(&(step, nth), |late| (late.step, late.nth));
        found.ok().map(|found| self.late[found].due)
    }

    /// The last step that is recorded.
    pub fn last(&self) -> Option<u64> {
        (self.first + self.images.len() as u64).checked_sub(1).filter(|_| !self.images.is_empty())
    }
}

/// What a recording holds of a run.
pub struct RecordedRun {
    /// What is recorded of each robot.
    pub robots: Vec<Rc<RecordedRobot>>,
    /// What each process collected of each sensor.
    pub readings: Vec<Rc<RecordedReadings>>,
    /// The MP's steps, what the operator wanted in them, and what its program recorded.
    pub script: Rc<Script>,
    /// The first fault that did not come from the programs: its step and its text.
    pub outside: Option<(u64, String)>,
    /// How the MP's program ended: nothing, or its fault's text; `None` when the recording does not go so far.
    pub end: Option<Option<String>>,
}

impl RecordedRun {
    /// What is recorded of a robot.
    pub fn robot(&self, name: &str) -> Option<&Rc<RecordedRobot>> {
        self.robots.iter().find(|robot| robot.name.as_str() == name)
    }

    /// What a process collected of a sensor; nothing where nothing is recorded.
    pub fn reading(&self, sensor: Name, by: ProcessId) -> Rc<RecordedReadings> {
        let found = self.readings.iter().find(|recorded| recorded.sensor == sensor && recorded.by == by);
        found.map_or_else(|| Rc::new(RecordedReadings::new(sensor, by)), Rc::clone)
    }

    /// The last step of which everything is recorded.
    pub fn last(&self) -> u64 {
        let robots = self.robots.iter().map(|robot| robot.last().unwrap_or(0));
        let outside = self.outside.iter().map(|(step, _)| step.saturating_sub(1));
        robots.chain(outside).chain([self.script.last()]).min().unwrap_or(0)
    }
}
