//! A run that is recorded, and a recording that is replayed.
//!
//! In: a cell and a file. Out: a run of which the file tells; or the comparison of another one with it.

use std::path::Path;
use std::rc::Rc;

use super::file::{McapFile, can_be_written};
use super::reader::{CutOff, NotReplayable, read};
use super::ring::{Pace, Recorder};
use super::{NotRecorded, Recording};
use mrroc_core::cell::{Cell, CellError, Layout};
use mrroc_core::control::replay::compare::{Compared, Comparison};

/// Begins to record a cell of this layout on the memory link.
pub(crate) fn begin(recording: &Recording, layout: &Layout) -> Result<Rc<Recorder>, NotRecorded> {
    let unwritable = |error: std::io::Error| {
        let (file, error) = (recording.file.clone(), error.to_string());
        NotRecorded::Unwritable { file, error }
    };
    can_be_written(&recording.file).map_err(unwritable)?;
    let (file, layout) = (recording.file.clone(), recording.of(layout.clone()));
    let about = layout.clone();
    let open = Box::new(move || Ok(Box::new(McapFile::create(&file, &about, "memory")?) as _));
    Recorder::begin(recording, layout, Pace::Virtual, open).map(Rc::new).map_err(unwritable)
}

/// A recording was not replayed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ReplayError {
    /// What is wrong with the file.
    #[error(transparent)]
    File(#[from] NotReplayable),
    /// What is wrong with the cell.
    #[error(transparent)]
    Cell(#[from] CellError),
}

impl Cell {
    /// Runs the cell's programs again on what `file` has recorded, on the memory link: what robots measured, sensors read
    /// and the operator wanted comes from the file, in place of drivers and virtual sensors. Compares every demand with
    /// the recorded one, to the bit, up to the first that differs, or up to a fault that came from outside.
    ///
    /// # Errors
    /// [`ReplayError`]: the file is no recording of this cell, or not whole; or what is wrong with the cell.
    pub fn replay(mut self, file: impl AsRef<Path>, cut_off: CutOff) -> Result<Compared, ReplayError> {
        let names = self.check()?;
        let tape = Rc::new(read(file.as_ref(), &self.layout(), cut_off)?);
        let comparison = Rc::new(Comparison::with(Rc::clone(&tape)));
        let witness: Rc<Comparison> = Rc::clone(&comparison);
        match self.replaying(tape).witnessed_by(witness).run_on_memory(&names) {
            // How it ends, the comparison tells: a recording may end before its programs do.
            Ok(_) | Err(CellError::Fault(_)) => Ok(comparison.outcome()),
            Err(error) => Err(error.into()),
        }
    }
}
