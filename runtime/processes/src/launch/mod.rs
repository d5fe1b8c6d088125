//! The launcher's side of a cell.
//!
//! In: a cell, and a plan of how to run it. Out: its processes, from their start to their end, and how the run ended.
//!
//! [`launcher`] begins a session and starts its [`process_set`]. In real time [`supervision`] keeps the cell, [`mp_watch`] says when
//! its MP stands still, and [`latch_notes`] what a person can do at a cell that has stopped. Under the virtual clock [`pacing`] resumes one
//! process after another. [`ending`] is how the run ended.

mod ending;
mod latch_notes;
pub(crate) mod launcher;
mod mp_watch;
mod pacing;
pub(crate) mod process_set;
mod supervision;

/// Time that the MP's program has to end after an abort, in addition to the time that its robots take to stop.
const ABORTING: core::time::Duration = core::time::Duration::from_secs(5);
