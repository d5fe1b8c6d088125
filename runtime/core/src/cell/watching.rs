//! Who looks on at the run of a cell: witnesses, and a recording; and a recording that it replays.

use std::rc::Rc;

use crate::control::plant::Body;
use crate::control::replay::RecordedRun;
use crate::observe::layout::{BodyLayout, Layout};
use crate::observe::recording::{NotRecorded, Recorder, Recording, RunRecord};
use crate::observe::witness::Witness;

/// Those who look on.
#[derive(Default)]
pub(super) struct Watching {
    pub witnesses: Vec<Rc<dyn Witness>>,
    /// Bodies that are shown to witnesses.
    pub bodies: Vec<(BodyLayout, Body)>,
    /// What the run is recorded to.
    pub recording: Option<Recording>,
    /// What writes it.
    pub recorder: Option<&'static dyn Recorder>,
    /// Whether observers look at simulated drives where those are, and not in their EDPs.
    pub watched_in_plant: bool,
    /// What it replays.
    pub recorded: Option<Rc<RecordedRun>>,
}

impl Watching {
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
