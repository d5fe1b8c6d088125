//! What is shown, as words of a datagram.
//!
//! In: records of the ring. Out: words, and from these what was shown, checked.

use std::path::{Path, PathBuf};
use std::time::Duration;

use mrroc_core::fault::{Name, ProcessId, Role};
use mrroc_core::link::Nanos;
use mrroc_core::observe::layout::Layout;
use mrroc_core::observe::ring::Record;
use mrroc_core::observe::step_observer::{ReadingState, StepEvent, StepRecord};
use mrroc_core::payload::{Payload, WORDS, Wire};

/// How long to wait for a plant, or for a thread of its, that takes nothing: shorter than a launcher waits for processes that end.
pub(super) const TIMEOUT: Duration = Duration::from_secs(3);

/// The path of the socket in the folder of a session.
pub(super) fn socket(folder: &Path) -> PathBuf {
    folder.join("picture")
}

/// What is sent of what a process shows; the words that are shown beside it follow.
#[derive(Clone, Copy, Payload)]
#[payload(crate = mrroc_core)]
enum Sent {
    Step(StepRecord),
    Reading { sensor: Name, step: u64, state: ReadingState, taken: u64 },
    Signals { step: u64 },
    End { lost: u64 },
}

/// What stands before these words.
#[derive(Clone, Copy, Payload)]
#[payload(crate = mrroc_core)]
struct Head {
    time: Nanos,
    role: Role,
    /// Zeros of a process that has none.
    name: [u64; Name::LEN],
    what: Sent,
    /// Number of the words.
    len: u64,
}

/// Something that was shown, or the end of what a process shows.
#[derive(Debug)]
pub(super) enum PictureRecord<'a> {
    /// At a time of the cell \[ns\] by a process, with its words.
    Something(Nanos, ProcessId, StepEvent, &'a [u64]),
    /// A process shows nothing more; so many things that it showed are lost.
    End(u64),
}

/// Whether a picture needs it.
pub(super) fn is_needed(what: &StepEvent) -> bool {
    matches!(what, StepEvent::Step(_) | StepEvent::Reading { .. } | StepEvent::Signals { .. })
}

/// Appends a record; nothing of what a picture does not need.
pub(super) fn put(words: &mut Vec<u64>, record: &Record) {
    let what = match record.what {
        StepEvent::Step(step) => Sent::Step(step),
        StepEvent::Reading { sensor, step, state, taken, .. } => Sent::Reading { sensor, step, state, taken },
        StepEvent::Signals { step } => Sent::Signals { step },
        _ => return,
    };
    put_sent(words, record.time, record.by, what, record.words());
}

/// Appends the end of what a process shows, of which so much is lost.
pub(super) fn put_end(words: &mut Vec<u64>, lost: u64) {
    put_sent(words, 0, ProcessId::PLANT, Sent::End { lost }, &[]);
}

fn put_sent(words: &mut Vec<u64>, time: Nanos, by: ProcessId, what: Sent, shown: &[u64]) {
    let mut name = [0; Name::LEN];
    by.name.iter().for_each(|by| by.put(&mut name));
    let begin = words.len();
    words.resize(begin + Head::LEN, 0);
    Head { time, role: by.role, name, what, len: shown.len() as u64 }.put(&mut words[begin..]);
    words.extend(shown);
}

/// Reads a datagram of a cell of this layout, up to the first words that make no sense.
pub(super) fn read<'a>(mut words: &'a [u64], layout: &'a Layout) -> impl Iterator<Item = PictureRecord<'a>> {
    std::iter::from_fn(move || next(&mut words, layout))
}

/// Reads what is sent next.
fn next<'a>(rest: &mut &'a [u64], layout: &Layout) -> Option<PictureRecord<'a>> {
    let Head { time, role, name, what, len } = Head::get(rest).ok()?;
    let len = usize::try_from(len).ok().filter(|len| *len <= WORDS)?;
    let (words, behind) = rest[Head::LEN..].split_at_checked(len)?;
    *rest = behind;
    let name = (name != [0; Name::LEN]).then(|| Name::get(&name)).transpose().ok()?;
    let what = match what {
        Sent::Step(step) => StepEvent::Step(step),
        Sent::Reading { sensor, step, state, taken } => {
            let known = layout.sensors.iter().find(|known| known.name == sensor.as_str())?;
            StepEvent::Reading { sensor, step, state, taken, shape: known.reading }
        }
        Sent::Signals { step } => StepEvent::Signals { step },
        Sent::End { lost } => return Some(PictureRecord::End(lost)),
    };
    Some(PictureRecord::Something(time, ProcessId { role, name }, what, words))
}
