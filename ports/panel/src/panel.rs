//! What the command line of a task program asks of this crate: `--panel`, `panel`, `panel FILE`.

use std::path::Path;
use std::process::ExitCode;
use std::rc::Rc;
use std::sync::Arc;

use mrroc_core::console::refused;
use mrroc_core::observe::layout::Layout;
use mrroc_launch::{Panel, RunObserver};

use crate::now::Appearance;
use crate::run::{attend, play};
use crate::run_history::OnMemory;

/// The panel in a browser.
#[derive(Clone, Copy, Debug)]
pub struct InBrowser;

impl Panel for InBrowser {
    fn attend(&self, layout: Layout, cell: &Path) -> ExitCode {
        attend(&layout, cell)
    }

    fn play(&self, layout: Layout, recording: &Path) -> ExitCode {
        match crate::recording::read(recording, &layout) {
            Ok(history) => play(Arc::new(Appearance::of(&layout)), history),
            Err(why) => refused(&why),
        }
    }

    fn observe_run(&self, layout: Layout) -> Rc<dyn RunObserver> {
        Rc::new(OnMemory::of(layout))
    }
}
