//! What is shown, as words of a datagram.
//!
//! In: records of the ring. Out: words, and from these what was shown, checked.

use std::path::{Path, PathBuf};
use std::time::Duration;

use mrroc_core::fault::{Name, ProcessId, Role};
use mrroc_core::link::Nanos;
use mrroc_core::observe::layout::Layout;
use mrroc_core::observe::ring::Record;
use mrroc_core::observe::step_observer::{ReadingState, StepEvent};
use mrroc_core::payload::{WORDS, Wire};

/// How long to wait for a plant, or for a thread of its, that takes nothing: shorter than a launcher waits for processes that end.
pub(super) const TIMEOUT: Duration = Duration::from_secs(3);

/// The path of the socket in the folder of a session.
pub(super) fn socket(folder: &Path) -> PathBuf {
    folder.join("picture")
}

/// The kinds of what is shown.
const STEP: u64 = 1;
const READING: u64 = 2;
const SIGNALS: u64 = 3;
const END: u64 = 4;

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
    match what {
        StepEvent::Step { .. } | StepEvent::Reading { .. } | StepEvent::Signals { .. } => true,
        StepEvent::Instruction { .. }
        | StepEvent::Abort { .. }
        | StepEvent::Jog { .. }
        | StepEvent::Late { .. }
        | StepEvent::LateRequest { .. }
        | StepEvent::Order { .. }
        | StepEvent::Found { .. }
        | StepEvent::Image { .. }
        | StepEvent::Currents { .. }
        | StepEvent::Fault { .. }
        | StepEvent::Body { .. }
        | StepEvent::End { .. } => false,
    }
}

/// Appends a record; nothing of what a picture does not need.
pub(super) fn put(words: &mut Vec<u64>, record: &Record) {
    let head = |words: &mut Vec<u64>, kind: u64| {
        words.extend([kind, record.time, record.by.role as u64]);
        put_name(words, record.by.name);
    };
    match record.what {
        StepEvent::Step { step, dt, duration, speed, suspended, reduced, aborting, stopping, resetting } => {
            head(words, STEP);
            words.extend([step, dt.to_bits(), duration.to_bits(), speed.to_bits()]);
            words.extend([suspended, reduced, aborting, stopping, resetting].map(u64::from));
        }
        StepEvent::Reading { sensor, step, state, taken, .. } => {
            head(words, READING);
            put_name(words, Some(sensor));
            words.extend([step, state as u64, taken]);
            put_words(words, record.words());
        }
        StepEvent::Signals { step } => {
            head(words, SIGNALS);
            words.push(step);
            put_words(words, record.words());
        }
        StepEvent::Instruction { .. }
        | StepEvent::Abort { .. }
        | StepEvent::Jog { .. }
        | StepEvent::Late { .. }
        | StepEvent::LateRequest { .. }
        | StepEvent::Order { .. }
        | StepEvent::Found { .. }
        | StepEvent::Image { .. }
        | StepEvent::Currents { .. }
        | StepEvent::Fault { .. }
        | StepEvent::Body { .. }
        | StepEvent::End { .. } => {}
    }
}

/// Appends the end of what a process shows, of which so much is lost.
pub(super) fn put_end(words: &mut Vec<u64>, lost: u64) {
    words.extend([END, lost]);
}

fn put_name(words: &mut Vec<u64>, name: Option<Name>) {
    let mut of_name = [0; Name::LEN];
    name.iter().for_each(|name| name.put(&mut of_name));
    words.extend(of_name);
}

fn put_words(words: &mut Vec<u64>, shown: &[u64]) {
    words.push(shown.len() as u64);
    words.extend(shown);
}

/// Reads a datagram of a cell of this layout, up to the first words that make no sense.
pub(super) fn read<'a>(words: &'a [u64], layout: &'a Layout) -> impl Iterator<Item = PictureRecord<'a>> {
    let mut reader = Reader { words, layout };
    std::iter::from_fn(move || reader.next())
}

struct Reader<'a> {
    words: &'a [u64],
    layout: &'a Layout,
}

impl<'a> Reader<'a> {
    fn next(&mut self) -> Option<PictureRecord<'a>> {
        let kind = self.word()?;
        if kind == END {
            return self.word().map(PictureRecord::End);
        }
        let time = self.word()?;
        let role = [Role::Mp, Role::Ecp, Role::Edp, Role::Vsp, Role::Plant, Role::Node];
        let role = *role.get(usize::try_from(self.word()?).ok()?)?;
        let by = ProcessId { role, name: self.name()? };
        let (what, words) = match kind {
            STEP => (self.step()?, &[][..]),
            READING => self.reading()?,
            SIGNALS => (StepEvent::Signals { step: self.word()? }, self.shown()?),
            _ => return None,
        };
        Some(PictureRecord::Something(time, by, what, words))
    }

    fn step(&mut self) -> Option<StepEvent> {
        Some(StepEvent::Step {
            step: self.word()?,
            dt: f64::from_bits(self.word()?),
            duration: f64::from_bits(self.word()?),
            speed: f64::from_bits(self.word()?),
            suspended: self.truth()?,
            reduced: self.truth()?,
            aborting: self.truth()?,
            stopping: self.truth()?,
            resetting: self.truth()?,
        })
    }

    fn reading(&mut self) -> Option<(StepEvent, &'a [u64])> {
        let sensor = self.name()??;
        let step = self.word()?;
        let states = [ReadingState::There, ReadingState::None, ReadingState::Fault, ReadingState::Lost];
        let state = *states.get(usize::try_from(self.word()?).ok()?)?;
        let taken = self.word()?;
        let known = self.layout.sensors.iter().find(|known| known.name == sensor.as_str())?;
        Some((StepEvent::Reading { sensor, step, state, taken, shape: known.reading }, self.shown()?))
    }

    fn word(&mut self) -> Option<u64> {
        let (first, rest) = self.words.split_first()?;
        self.words = rest;
        Some(*first)
    }

    fn truth(&mut self) -> Option<bool> {
        match self.word()? {
            0 => Some(false),
            1 => Some(true),
            _ => None,
        }
    }

    /// A name, or none; nothing if it is damaged.
    fn name(&mut self) -> Option<Option<Name>> {
        let (words, rest) = self.words.split_at_checked(Name::LEN)?;
        self.words = rest;
        if words.iter().all(|word| *word == 0) { Some(None) } else { Name::get(words).ok().map(Some) }
    }

    fn shown(&mut self) -> Option<&'a [u64]> {
        let len = usize::try_from(self.word()?).ok().filter(|len| *len <= WORDS)?;
        let (words, rest) = self.words.split_at_checked(len)?;
        self.words = rest;
        Some(words)
    }
}
