//! The recorder of MCAP files: of a run in one process, or of a cell of processes.
//!
//! In: what is to be recorded, and the cell's layout. Out: an observer of the run, which records it.

use std::any::Any;
use std::io;
use std::path::Path;
use std::rc::Rc;

use mrroc_core::fault::ProcessId;
use mrroc_core::link::Clock;
use mrroc_core::observe::layout::Layout;
use mrroc_core::observe::recording::{CommandRecord, FramesTo, NotRecorded, Recorder, Recording, RunRecord};
use mrroc_core::sensor::FrameSink;

use crate::commands;
use crate::file::{McapFile, can_be_written};
use crate::frames::FrameFiles;
use crate::relay::{Relay, join};
use crate::ring;

/// Records to MCAP files.
#[derive(Clone, Copy, Debug)]
pub struct Mcap;

impl Recorder for Mcap {
    fn begin(&self, recording: &Recording, layout: &Layout) -> Result<Rc<dyn RunRecord>, NotRecorded> {
        let unwritable = |error: io::Error| NotRecorded::Unwritable {
            file: recording.file().to_owned(),
            error: error.to_string(),
        };
        can_be_written(recording.file()).map_err(unwritable)?;
        let file = recording.file().to_owned();
        let layout = recording.of(layout.clone());
        let about = layout.clone();
        let open = Box::new(move || Ok(Box::new(McapFile::create(&file, &about, "memory")?) as _));
        let begun = ring::begin(recording, layout, Clock::Virtual, open).map_err(unwritable)?;
        Ok(Rc::new(begun))
    }

    fn listen(
        &self,
        recording: &Recording,
        layout: &Layout,
        folder: &Path,
        clock: Clock,
    ) -> Result<Box<dyn Any>, NotRecorded> {
        Ok(Box::new(Relay::listen(folder, recording, layout, clock)?))
    }

    fn join(
        &self,
        recording: Option<&Recording>,
        layout: &Layout,
        process: ProcessId,
        folder: &Path,
    ) -> Option<Rc<dyn RunRecord>> {
        join(recording, layout, process, folder).map(|record| record as Rc<dyn RunRecord>)
    }

    fn commands(&self, folder: &Path, clock: Clock) -> Option<Box<dyn CommandRecord>> {
        commands::begin(folder, clock)
    }

    fn frames(&self, to: &FramesTo, sensor: &str) -> Box<dyn FrameSink> {
        Box::new(FrameFiles::of(to, sensor))
    }
}
