//! Who observes the run of a cell: observers of its steps, and a recording; and a recording that it replays.

use core::time::Duration;
use std::path::PathBuf;
use std::rc::Rc;

use crate::console::complain;
use crate::control::plant::Body;
use crate::control::replay::RecordedRun;
use crate::model::fault::ProcessId;
use crate::model::time::Clock;
use crate::observe::layout::{BodyLayout, Layout};
use crate::observe::recording::{FramesTo, NotRecorded, Recorder, Recording, RunRecord};
use crate::observe::solid::ObstacleLayout;
use crate::observe::step_observer::{SharedStepObserver, StepObserver};
use crate::observe::subscription::Subscription;

/// Those who observe.
#[derive(Default)]
pub(super) struct Watching {
    pub observers: Vec<Rc<dyn StepObserver>>,
    /// Those who observe its lower cells as well: recordings.
    pub of_all: Vec<Rc<dyn StepObserver>>,
    /// Those who are shown what a picture needs, of all processes.
    pub of_picture: Vec<SharedStepObserver>,
    /// Bodies that are shown to observers.
    pub bodies: Vec<(BodyLayout, Body)>,
    /// What stands in the cell, for those who draw it.
    pub obstacles: Vec<ObstacleLayout>,
    /// What the run is recorded to.
    pub recording: Option<Recording>,
    /// What writes it.
    pub recorder: Option<&'static dyn Recorder>,
    /// The folder for the frames of sensors.
    pub frames: Option<PathBuf>,
    /// Whether observers look at simulated drives where those are, and not in their EDPs.
    pub watched_in_plant: bool,
    /// What shows the cell to programs of others.
    pub subscriptions: Vec<Rc<dyn Subscription>>,
    /// What it replays.
    pub recorded: Option<Rc<RecordedRun>>,
}

impl Watching {
    /// Where the frames of sensors go, in a cell with steps of this length; nothing if nobody wants them.
    pub fn frames_to(&self, step: Duration) -> Option<(FramesTo, &'static dyn Recorder)> {
        let to = FramesTo { recording: self.recording.clone(), folder: self.frames.clone(), step };
        let is_wanted = to.recording.is_some() || to.folder.is_some();
        self.recorder.filter(|_| is_wanted).map(|recorder| (to, recorder))
    }

    /// Begins to show a process of a cell that is made of this, or all of them, to programs of others. What cannot be shown is told,
    /// and the cell runs all the same.
    pub fn begin_subscriptions(
        &self,
        process: Option<ProcessId>,
        layout: &Layout,
        clock: Clock,
    ) -> Vec<Rc<dyn RunRecord>> {
        let begin = |subscription: &Rc<dyn Subscription>| {
            subscription.begin(process, layout, clock).unwrap_or_else(|why| {
                complain(&format!("warning: nobody can subscribe at `{}`: {why}", subscription.name()));
                None
            })
        };
        self.subscriptions.iter().filter_map(begin).collect()
    }

    /// Begins the recording that is asked for, of a cell that is made of this.
    ///
    /// # Errors
    /// [`NotRecorded`]: nothing can write it.
    pub fn begin_record(&self, layout: &Layout) -> Result<Option<Rc<dyn RunRecord>>, NotRecorded> {
        let Some(recording) = &self.recording else { return Ok(None) };
        let recorder = self.recorder.ok_or(NotRecorded::NoFeature)?;
        recorder.begin(recording, layout).map(Some)
    }
}
