//! One page that is connected: what it is sent, and in which order.
//!
//! In: the time, and what there is to tell. Out: one frame after another, each when the one before has been taken. A page that does not read is
//! disconnected, and nobody waits for it.

use core::time::Duration;
use std::collections::VecDeque;
use std::sync::Arc;

use axum::extract::ws::Utf8Bytes;
use serde_json::json;

use crate::console_session::CellSnapshot;
use crate::now::Appearance;
use crate::rules::authority::Page;
use crate::rules::rate::Rate;

/// How long a page may take to show the token, and to read what it is sent.
pub const TOKEN: Duration = Duration::from_secs(5);
pub const READS: Duration = Duration::from_secs(5);

/// How long a page that is disconnected is told what it was to be told before, and why.
pub const FAREWELL: Duration = Duration::from_secs(1);

/// Answers that wait for a page.
const ANSWERS: usize = 64;

/// Notes that wait for a page: of more, the oldest are dropped.
const NOTES: usize = 32;

/// What a page is sent.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Outgoing {
    /// A message.
    Text(Utf8Bytes),
    /// Why it is disconnected.
    Close(&'static str),
}

/// What a connection needs next.
#[derive(Debug)]
#[must_use]
pub struct NextAction {
    /// To be sent; whoever sends it [says](crate::pages::Pages::sent) when that is done.
    pub send: Option<Outgoing>,
    /// When to look again at the latest.
    pub until: Option<Duration>,
    /// Whether anything that comes is still taken.
    pub listens: bool,
}

/// Something that pages are told whenever it has changed.
#[derive(Debug, Default)]
pub struct Changing<T> {
    value: T,
    version: u64,
}

impl<T> Changing<T> {
    /// What it is.
    pub const fn get(&self) -> &T {
        &self.value
    }

    /// It has changed.
    pub fn set(&mut self, value: T) {
        (self.value, self.version) = (value, self.version + 1);
    }

    /// What it is, for whom has not been told of it yet.
    fn news(&self, told: &mut Option<u64>) -> Option<&T> {
        (told.replace(self.version) != Some(self.version)).then_some(&self.value)
    }
}

/// What all pages are told of.
pub struct Scene {
    pub looks: Arc<Appearance>,
    /// What a running cell shows; of a run that is over, nothing.
    pub shown: Changing<CellSnapshot>,
    /// The poses that robots were taught.
    pub taught: Changing<Option<Utf8Bytes>>,
}

/// Whether a page is let in.
#[derive(Debug)]
enum State {
    /// It connects.
    Begins,
    /// It has to show the token until then.
    Unknown { until: Duration },
    /// It has shown the token.
    Known,
    /// It is told what waits for it until then, and at last why it is disconnected.
    Leaves { until: Duration, why: Option<&'static str> },
}

/// A page's connection.
#[derive(Debug)]
pub struct Session {
    state: State,
    /// How often it may speak.
    pub rate: Rate,
    /// Messages of it that were none.
    pub bad: usize,
    /// Whether a stop that it asked for is under way.
    pub stopping: bool,
    /// What it has asked for and is not answered yet.
    pub pending: usize,
    /// Its number, once it is let in.
    own: Option<Page>,
    first: Option<Utf8Bytes>,
    meshes: usize,
    /// What it was told of who has authority.
    holder: Option<Option<Page>>,
    answers: VecDeque<Utf8Bytes>,
    notes: VecDeque<Arc<str>>,
    shown: Option<u64>,
    taught: Option<u64>,
    /// Until when what is being sent has to be taken.
    sending: Option<Duration>,
}

/// A page's answers are full.
#[derive(Debug)]
pub struct DoesNotRead;

impl Session {
    /// Of a page whose connection is being made.
    pub fn new() -> Session {
        Session {
            state: State::Begins,
            rate: Rate::begin(Duration::ZERO),
            bad: 0,
            stopping: false,
            pending: 0,
            own: None,
            first: None,
            meshes: 0,
            holder: None,
            answers: VecDeque::new(),
            notes: VecDeque::new(),
            shown: None,
            taught: None,
            sending: None,
        }
    }

    /// It is connected, and has to show the token.
    pub fn begin(&mut self, now: Duration) {
        self.state = State::Unknown { until: now + TOKEN };
    }

    /// It has shown the token, and is told first what stays as it is.
    pub fn let_in(&mut self, page: Page, now: Duration, first: Utf8Bytes) {
        (self.state, self.own) = (State::Known, Some(page));
        self.rate = Rate::begin(now);
        self.first = Some(first);
    }

    /// It is disconnected, at a time at the latest, and told why.
    pub fn leave(&mut self, until: Duration, why: &'static str) {
        self.state = State::Leaves { until, why: Some(why) };
    }

    /// Its number, if it is let in.
    pub const fn page(&self) -> Option<Page> {
        if let State::Known = self.state { self.own } else { None }
    }

    /// Whether it connects, or has to show the token.
    pub const fn has_shown_nothing(&self) -> bool {
        matches!(self.state, State::Begins | State::Unknown { .. })
    }

    /// Whether it has to show the token now.
    pub const fn is_unknown(&self) -> bool {
        matches!(self.state, State::Unknown { .. })
    }

    /// It is answered.
    ///
    /// # Errors
    /// [`DoesNotRead`]
    pub fn answer(&mut self, text: Utf8Bytes) -> Result<(), DoesNotRead> {
        if self.answers.len() >= ANSWERS {
            return Err(DoesNotRead);
        }
        self.answers.push_back(text);
        Ok(())
    }

    /// It is told a sentence, if it is let in.
    pub fn note(&mut self, text: &Arc<str>) {
        if self.own.is_none() {
            return;
        }
        if self.notes.len() >= NOTES {
            self.notes.pop_front();
        }
        self.notes.push_back(Arc::clone(text));
    }

    /// What was to be sent has been taken.
    pub fn sent(&mut self) {
        self.sending = None;
    }

    /// Whether it was let in, and has not taken in time what it is sent.
    pub fn does_not_read(&self, now: Duration) -> bool {
        self.page().is_some() && self.sending.is_some_and(|until| now >= until)
    }

    /// What its connection needs next, where that page has authority; `None`: it is closed.
    pub fn poll(&mut self, now: Duration, scene: &Scene, holder: Option<Page>) -> Option<NextAction> {
        let until = match self.state {
            State::Unknown { until } | State::Leaves { until, .. } => Some(until),
            State::Begins | State::Known => None,
        };
        if until.is_some_and(|until| now >= until) {
            return None;
        }
        let mut send = None;
        if self.sending.is_none() {
            send = self.next(scene, holder);
            if send.is_some() {
                self.sending = Some(now + READS);
            } else if matches!(self.state, State::Leaves { why: None, .. }) {
                return None;
            }
        }
        let listens = matches!(self.state, State::Unknown { .. } | State::Known);
        // A frame that one that leaves does not take is waited for no longer than the rest.
        let until = until.or(self.sending);
        Some(NextAction { send, until, listens })
    }

    /// What it is told next.
    fn next(&mut self, scene: &Scene, holder: Option<Page>) -> Option<Outgoing> {
        if self.own.is_some()
            && let Some(text) = self.news(scene, holder)
        {
            return Some(Outgoing::Text(text));
        }
        if let State::Leaves { why, .. } = &mut self.state
            && self.pending == 0
        {
            return why.take().map(Outgoing::Close);
        }
        None
    }

    /// What a page that was let in is told next: first what stays as it is, then who has authority, and then answers before all else.
    fn news(&mut self, scene: &Scene, holder: Option<Page>) -> Option<Utf8Bytes> {
        if let Some(first) = self.first.take() {
            return Some(first);
        }
        if let Some(mesh) = scene.looks.meshes().messages().get(self.meshes) {
            self.meshes += 1;
            return Some(mesh.as_str().into());
        }
        if self.holder != Some(holder) {
            self.holder = Some(holder);
            let yours = holder.is_some() && holder == self.own;
            return Some(json!({"kind": "authority", "page": holder, "yours": yours}).to_string().into());
        }
        if let Some(answer) = self.answers.pop_front() {
            return Some(answer);
        }
        // One that leaves is told nothing more than what it has asked for.
        if self.page().is_none() && self.pending == 0 {
            return None;
        }
        if let Some(text) = self.notes.pop_front() {
            return Some(json!({"kind": "note", "text": &*text}).to_string().into());
        }
        if let Some(Some(taught)) = scene.taught.news(&mut self.taught) {
            return Some(taught.clone());
        }
        let shown = scene.shown.news(&mut self.shown)?;
        match &shown.over {
            Some(why) => Some(json!({"kind": "over", "text": why}).to_string().into()),
            None => shown.text.clone(),
        }
    }
}
