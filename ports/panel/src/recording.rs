//! A recording, as a page plays it.
//!
//! In: an MCAP file that `--record` has written. Out: the history of its run; what a page does not show is passed over.

use std::path::Path;

use mrroc_core::fault::ProcessId;
use mrroc_core::observe::layout::Layout;
use mrroc_core::observe::step_observer::ReadingState;
use mrroc_recording::{RecordedMessage, Sample, each_message_of};

use crate::readings::of_words;
use crate::run_history::RunHistory;

/// The largest file that is played \[bytes\].
const LARGEST: u64 = 1 << 30;

/// Reads a recording of a cell of this layout; of one that was cut off, what there is.
///
/// # Errors
/// What is wrong with the file.
pub fn read(file: &Path, layout: &Layout) -> Result<RunHistory, String> {
    let named = |what: &str| format!("{}: {what}", file.display());
    if file.metadata().is_ok_and(|about| about.len() > LARGEST) {
        return Err(named("is larger than 1 GiB\n help: record a shorter run, or fewer robots"));
    }
    let mut history = RunHistory::of(layout);
    let (mut start, mut last) = (None, 0);
    let read = each_message_of(file, layout, |message| {
        let time = message.time.saturating_sub(*start.get_or_insert(message.time));
        last = last.max(time);
        take(&mut history, layout, time, &message);
    });
    read.map_err(|wrong| wrong.to_string())?;
    history.end(last, None);
    if history.lasts() == 0.0 {
        let help = "give a file that --record has written, of this cell";
        return Err(named(&format!("shows no robot of this cell\n help: {help}")));
    }
    Ok(history)
}

fn take(history: &mut RunHistory, layout: &Layout, time: u64, message: &RecordedMessage<'_>) {
    // Of most steps nothing is kept of a robot: they are not read.
    let is_image = message.topic.strip_prefix("/robots/").is_some_and(|name| !name.contains('/'));
    if is_image && !history.is_due(time) {
        return;
    }
    match message.sample(layout) {
        Some(Sample::Step(record)) => history.step(time, &record),
        Some(Sample::Instruction { process, doing, by }) => {
            history.instruction(&process.to_string(), doing, &by);
        }
        Some(Sample::Event { process: ProcessId::MP, what, text, .. })
            if matches!(&*what, "fault" | "end") && !text.is_empty() =>
        {
            history.fault(text, None);
        }
        Some(Sample::Body { body, pose: Some(pose) }) => history.body(body, pose),
        Some(Sample::Reading { sensor, state: ReadingState::There, words, .. }) => {
            history.reading(time, sensor, Some(of_words(layout.sensors[sensor].reading, &words)));
        }
        Some(Sample::Reading { sensor, state: ReadingState::Fault, .. }) => {
            history.reading(time, sensor, None);
        }
        Some(Sample::Signals { robot, signals, .. }) => {
            history.signals(&layout.robots[robot].name, signals);
        }
        Some(Sample::Image(image)) => {
            if let (Some(tool), Some(in_force)) = (image.measured.pose, image.tool) {
                let joints = [&*image.demanded.joints, &*image.measured.joints];
                history.robot(time, &layout.robots[image.robot].name, joints, [tool, in_force]);
            }
        }
        _ => {}
    }
}
