//! In place of replays, where the feature is left out: whoever asks for one is told so.

use std::path::Path;
use std::process::ExitCode;

use mrroc_core::cell::Cell;
use mrroc_core::console::refused;
use mrroc_recording::NotRecorded;

pub(super) fn replay(_: Cell, _: &Path, _: bool, _: bool) -> ExitCode {
    refused(&NotRecorded::NoFeature)
}
