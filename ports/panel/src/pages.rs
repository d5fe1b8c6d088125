//! All pages that are connected: what they are told, and what becomes of what they ask for.
//!
//! In: what they say, what the console server answers, and when, by the machine's monotonic clock. Out: frames for each of them, requests to the console server, and when to
//! look again. Nothing here reads a clock, waits, or touches a socket: [`driver`](crate::driver) does. Nothing is shown and nothing is done before a page
//! has shown the token. A page that speaks too much, says what is no message, or does not read, is disconnected; no other page and no cell waits for it.

use core::time::Duration;
use std::collections::{BTreeMap, VecDeque};
use std::sync::Arc;

use axum::extract::ws::Utf8Bytes;
use mrroc_core::operator::button::Button;
use mrroc_core::operator::{Answer, OnBehalf, Request};
use serde_json::json;

use crate::console_session::CellSnapshot;
use crate::control::Control;
use crate::events::{Action, Key, PageEvent, To};
use crate::now::Appearance;
use crate::rules::PAGES;
use crate::rules::authority::Page;
use crate::rules::request::{Message, PageRequest};
use crate::rules::token::Token;
use crate::run_history::RunHistory;
use crate::session::{Changing, DoesNotRead, FAREWELL, NextAction, READS, Scene, Session};
use crate::teaching::WorkOutcome;

/// Messages that are none, until a page is disconnected.
const BAD: usize = 8;

/// All pages.
pub struct Pages {
    token: Token,
    /// Of a run that is over.
    pub(crate) history: Option<Box<RunHistory>>,
    pub(crate) scene: Scene,
    pub(crate) control: Control,
    sessions: BTreeMap<Key, Session>,
    /// How many connections there have been, and how many pages were let in.
    keys: Key,
    count: Page,
    /// Requests that wait for files.
    pub(crate) files: usize,
    actions: VecDeque<Action>,
    /// Whether there is something new to tell.
    has_news: bool,
}

/// A time of the machine's monotonic clock \[ns\].
fn nanos(now: Duration) -> u64 {
    u64::try_from(now.as_nanos()).unwrap_or(u64::MAX)
}

impl Pages {
    /// Of a cell that runs; of a run that is over, with its history.
    #[must_use]
    pub fn new(looks: Arc<Appearance>, token: Token, history: Option<Box<RunHistory>>) -> Pages {
        let scene = Scene { looks, shown: Changing::default(), taught: Changing::default() };
        Pages {
            token,
            history,
            scene,
            control: Control::default(),
            sessions: BTreeMap::new(),
            keys: 0,
            count: 0,
            files: 0,
            actions: VecDeque::new(),
            has_news: false,
        }
    }

    /// The cell shows this now.
    pub fn show(&mut self, shown: CellSnapshot) {
        self.scene.shown.set(shown);
        self.has_news = true;
    }

    /// Robots were taught these poses.
    pub fn teach(&mut self, taught: Utf8Bytes) {
        self.scene.taught.set(Some(taught));
        self.has_news = true;
    }

    /// A place for a page, whose connection is being made; `None`: there are too many. The oldest of those that have not shown the token
    /// makes room.
    pub fn connect(&mut self) -> Option<Key> {
        if self.sessions.len() >= PAGES {
            let oldest = self.sessions.iter().find(|(_, session)| session.has_shown_nothing());
            let oldest = oldest.map(|(&key, _)| key)?;
            self.forget(oldest);
            self.has_news = true;
        }
        self.keys += 1;
        self.sessions.insert(self.keys, Session::new());
        Some(self.keys)
    }

    /// The connection is made: the page has to show the token.
    pub fn begin(&mut self, key: Key, now: Duration) {
        if let Some(session) = self.sessions.get_mut(&key) {
            session.begin(now);
        }
    }

    /// The connection is gone, whatever it was.
    pub fn forget(&mut self, key: Key) {
        self.sessions.remove(&key);
    }

    /// What a connection needs next; `None`: it is to be closed.
    pub fn poll(&mut self, key: Key, now: Duration) -> Option<NextAction> {
        if self.sessions.get(&key)?.does_not_read(now) {
            self.leave(key, now, ": it does not read");
        }
        let holder = self.control.holder();
        let next = self.sessions.get_mut(&key)?.poll(now, &self.scene, holder);
        if next.is_none() {
            self.forget(key);
        }
        next
    }

    /// What was to be sent over a connection has been taken.
    pub fn sent(&mut self, key: Key) {
        if let Some(session) = self.sessions.get_mut(&key) {
            session.sent();
        }
    }

    /// Nothing can be sent over a connection any more.
    pub fn fail(&mut self, key: Key, now: Duration, why: &str) {
        self.leave(key, now, &format!(": {why}"));
        self.forget(key);
    }

    /// What is to be done, in this order.
    pub fn actions(&mut self) -> VecDeque<Action> {
        core::mem::take(&mut self.actions)
    }

    /// Whether pages have something new to be told since this was asked last: then each is to be looked after.
    pub fn has_news(&mut self) -> bool {
        core::mem::take(&mut self.has_news)
    }

    /// Ends the hold of a page that has said nothing for too long, and takes authority from it. When to look again, if nothing else happens.
    pub fn look(&mut self, now: Duration) -> Option<Duration> {
        if let Some((page, button)) = self.control.lapsed_hold(now) {
            self.tell_console_server(OnBehalf { page, heard: nanos(now) }, vec![Request::Press(button)]);
            self.note(&format!("page {page} did not renew its hold"));
        }
        if let Some((page, requests)) = self.control.lapse(now) {
            self.tell_console_server(OnBehalf { page, heard: nanos(now) }, requests);
            self.note(&format!("page {page} was silent for too long, and has lost control"));
        }
        self.control.lapses()
    }

    /// A page says something.
    pub fn hear(&mut self, key: Key, now: Duration, heard: PageEvent<'_>) {
        // What has lapsed by now has done so before this, and the console server is told.
        self.look(now);
        let holder = self.control.holder();
        let Some(session) = self.sessions.get(&key) else { return };
        if session.is_unknown() {
            self.introduce(key, now, &heard);
        } else if let Some(page) = session.page()
            && let Err(why) = self.take(key, page, now, heard)
        {
            self.leave(key, now, &why);
        }
        self.has_news |= self.control.holder() != holder;
    }

    /// The first thing that a page says is the token, or it is gone.
    fn introduce(&mut self, key: Key, now: Duration, heard: &PageEvent<'_>) {
        let PageEvent::Text(text) = *heard else { return self.forget(key) };
        let shown = match Message::read(text) {
            Ok(Message { asked: PageRequest::Token(token), .. }) => self.token.is(&token),
            Ok(_) | Err(_) => false,
        };
        if shown {
            self.count += 1;
            self.note(&format!("page {} looks on", self.count));
        }
        let lasts = self.history.as_ref().map(|history| history.lasts());
        let Some(session) = self.sessions.get_mut(&key) else { return };
        if !shown {
            return session.leave(now + READS, "this is not the token");
        }
        let mut layout = self.scene.looks.layout(lasts);
        layout["page"] = json!(self.count);
        session.let_in(self.count, now, layout.to_string().into());
    }

    /// Takes what a page says; or why it is disconnected, in words that follow others.
    fn take(&mut self, key: Key, page: Page, now: Duration, heard: PageEvent<'_>) -> Result<(), String> {
        let Some(session) = self.sessions.get_mut(&key) else { return Ok(()) };
        let text = match heard {
            PageEvent::Text(text) => text,
            PageEvent::Control if session.rate.may(now) => return Ok(()),
            PageEvent::Closed => return Err(String::new()),
            PageEvent::Binary | PageEvent::Control => return Err(": it sent what is no text".to_owned()),
            PageEvent::Failed(error) => return Err(format!(": {error}")),
        };
        let by = OnBehalf { page, heard: nanos(now) };
        let may = session.rate.may(now);
        let done = match Message::read(text) {
            // A stop is taken however much was said before; one that comes while the page's last one is under way is part of it.
            Ok(Message { number, asked: PageRequest::Stop }) => {
                if !session.stopping {
                    self.stop(key, by, number);
                }
                return Ok(());
            }
            _ if !may => return Err(": it said too much".to_owned()),
            Ok(message) => self.handle(key, by, now, message),
            Err(why) => {
                session.bad += 1;
                if session.bad > BAD {
                    return Err(": it said what is no message".to_owned());
                }
                self.answer(key, 0, &Answer::Refused(why.to_string()))
            }
        };
        done.map_err(|DoesNotRead| ": it does not read".to_owned())
    }

    /// Stops the cell, for any page with the token.
    fn stop(&mut self, key: Key, by: OnBehalf, number: u64) {
        if self.history.is_some() {
            let _ = self.answer(key, number, &Answer::Refused("the run is over".to_owned()));
            return;
        }
        if let Some(session) = self.sessions.get_mut(&key) {
            session.stopping = true;
        }
        self.ask(key, by, number, Request::Press(Button::Stop));
    }

    /// Disconnects a page, which is told why, and what it was to be told before.
    fn leave(&mut self, key: Key, now: Duration, why: &str) {
        let Some(session) = self.sessions.get_mut(&key) else { return };
        let Some(page) = session.page() else { return };
        session.leave(now + FAREWELL, "the panel has closed the connection");
        // First of all: nobody holds anything for a page that is gone.
        let left = self.control.leave(page);
        self.tell_console_server(OnBehalf { page, heard: nanos(now) }, left);
        self.note(&format!("page {page} is gone{why}"));
    }

    /// A page that waits for an answer.
    fn awaits(&mut self, key: Key, page: Page, number: u64) -> To {
        if let Some(session) = self.sessions.get_mut(&key) {
            session.pending += 1;
        }
        To { key, page, number }
    }

    /// Asks the console server for something that a page is told of.
    pub(crate) fn ask(&mut self, key: Key, by: OnBehalf, number: u64, request: Request) {
        let to = Some(self.awaits(key, by.page, number));
        self.actions.push_back(Action::Ask { request, by, to });
    }

    /// Begins work with the files of poses.
    pub(crate) fn begin_work(&mut self, key: Key, page: Page, number: u64, asked: PageRequest) {
        let (to, shown) = (self.awaits(key, page, number), self.scene.shown.get().clone());
        self.files += 1;
        self.actions.push_back(Action::Files { asked, shown, to });
    }

    /// Asks the console server for something of which no page waits for the answer.
    pub(crate) fn tell_console_server(&mut self, by: OnBehalf, requests: Vec<Request>) {
        if self.history.is_none() {
            let ask = |request| Action::Ask { request, by, to: None };
            self.actions.extend(requests.into_iter().map(ask));
        }
    }

    /// The console server has answered; `None`: it never will.
    pub fn answered(&mut self, to: To, request: &Request, answer: Option<Answer>) {
        let To { key, page, number } = to;
        let answer = answer.unwrap_or_else(|| Answer::Refused("the panel is ending".to_owned()));
        let word = match request {
            // Why a hold moves nothing: ten times a second at most, so that no other page is told.
            Request::Press(Button::Hold(renewal) | Button::Jog(renewal, ..)) if renewal.count() > 0 => {
                if let Answer::Refused(why) | Answer::Pending(why) = answer {
                    let _ = self.answer(key, number, &Answer::Refused(why));
                }
                return self.is_answered(key, false);
            }
            Request::Press(Button::Hold(_)) => "hold".to_owned(),
            Request::Press(Button::Jog(_, robot, order)) => format!("jog {robot} {order}"),
            Request::Press(Button::LetGo(_)) => "let go".to_owned(),
            Request::Take => "take control".to_owned(),
            _ => request.to_string(),
        };
        if *request == Request::Take && matches!(answer, Answer::Refused(_)) {
            // Another console has it: this page has nothing either.
            self.control.leave(page);
        }
        let (outcome, text) = answer.parts();
        self.note(&format!("page {page}: {word}: {outcome}: {text}"));
        let _ = self.answer(key, number, &answer);
        self.is_answered(key, *request == Request::Press(Button::Stop));
    }

    /// Something was done with the files of poses, which are these now.
    pub fn worked(&mut self, to: To, outcome: Result<WorkOutcome, String>, taught: Option<Utf8Bytes>) {
        let To { key, page, number } = to;
        self.files -= 1;
        if let Some(taught) = taught {
            self.teach(taught);
        }
        // A page that does not read is disconnected when it is sent something.
        let _ = match outcome {
            Ok(WorkOutcome::Changed(told)) => {
                self.note(&format!("page {page}: {told}"));
                self.answer(key, number, &Answer::Done(told))
            }
            Ok(WorkOutcome::ToolPath(path)) => {
                let said =
                    json!({"kind": "answer", "n": number, "outcome": "done", "text": "", "path": path});
                self.tell(key, said.to_string().into())
            }
            Err(why) => self.answer(key, number, &Answer::Refused(why)),
        };
        self.is_answered(key, false);
    }

    fn is_answered(&mut self, key: Key, is_stop: bool) {
        if let Some(session) = self.sessions.get_mut(&key) {
            session.pending -= 1;
            session.stopping &= !is_stop;
        }
        self.has_news = true;
    }

    /// Answers what a page has asked for.
    ///
    /// # Errors
    /// [`DoesNotRead`]
    pub(crate) fn answer(&mut self, key: Key, number: u64, answer: &Answer) -> Result<(), DoesNotRead> {
        if number == 0 && matches!(answer, Answer::Done(_)) {
            return Ok(());
        }
        let mut said = json!(answer);
        (said["kind"], said["n"]) = ("answer".into(), number.into());
        self.tell(key, said.to_string().into())
    }

    /// Tells a page what it has asked for.
    ///
    /// # Errors
    /// [`DoesNotRead`]
    pub(crate) fn tell(&mut self, key: Key, text: Utf8Bytes) -> Result<(), DoesNotRead> {
        self.sessions.get_mut(&key).map_or(Ok(()), |session| session.answer(text))
    }

    /// Tells all pages and the terminal what happened.
    pub(crate) fn note(&mut self, text: &str) {
        self.actions.push_back(Action::Say(text.to_owned()));
        let text: Arc<str> = text.into();
        self.sessions.values_mut().for_each(|session| session.note(&text));
        self.has_news = true;
    }
}
