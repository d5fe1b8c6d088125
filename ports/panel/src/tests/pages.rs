//! Pages, their console server and their clock, in one thread.

use std::collections::BTreeMap;
use std::collections::VecDeque;

use mrroc_core::operator::{Answer, Request};
use serde_json::Value;

use super::*;
use crate::events::{Action, Key, PageEvent, To};
use crate::pages::Pages;
use crate::poses::Poses;
use crate::rules::request::PageRequest;
use crate::rules::token::Token;
use crate::run_history::RunHistory;
use crate::session::Outgoing;
use crate::teaching;

/// What a console server answers to a request.
type Answers = Box<dyn FnMut(&Request) -> Option<Answer>>;

/// Pages of a cell that is not there.
pub struct Fixture {
    pub pages: Pages,
    pub looks: Arc<Appearance>,
    pub token: String,
    pub now: Duration,
    answers: Answers,
    /// What the console server was asked for and does not answer yet.
    pub waiting: VecDeque<(To, Request)>,
    /// What it was asked for, and when.
    pub asked: VecDeque<(Duration, Request)>,
    /// What the terminal was told.
    pub said: Vec<String>,
    /// The files of poses, if there are any; work with them that waits, if they do not answer.
    pub poses: Option<Poses>,
    pub work: VecDeque<(To, PageRequest, CellSnapshot)>,
    /// What each page was sent and has not heard, and when a frame that it does not take was sent.
    sent: BTreeMap<Key, VecDeque<Value>>,
    /// Pages that do not read.
    pub stuck: Vec<Key>,
    /// Pages whose connections were closed, when, and what they were told at last.
    pub closed: BTreeMap<Key, (Duration, Option<&'static str>)>,
}

/// Pages of a cell whose console server does all that it is asked for.
pub fn fixture() -> Fixture {
    fixture_by(|request| Some(Answer::Done(format!("{request}"))))
}

/// The same, whose console server answers so; nothing, if it does not answer.
pub fn fixture_by(answers: impl FnMut(&Request) -> Option<Answer> + 'static) -> Fixture {
    let mut fixture = of_history(None);
    fixture.answers = Box::new(answers);
    fixture.pages.show(shown(&fixture.looks));
    fixture
}

/// Pages of a run that is over.
pub fn of_history(history: Option<Box<RunHistory>>) -> Fixture {
    let (looks, token) = (Arc::new(looks()), Token::draw().expect("random numbers"));
    Fixture {
        pages: Pages::new(Arc::clone(&looks), token, history),
        looks,
        token: token.to_string(),
        // A machine that has been on for a while.
        now: MS(1_000_000),
        answers: Box::new(|_| None),
        waiting: VecDeque::new(),
        asked: VecDeque::new(),
        said: Vec::new(),
        poses: None,
        work: VecDeque::new(),
        sent: BTreeMap::new(),
        stuck: Vec::new(),
        closed: BTreeMap::new(),
    }
}

impl Fixture {
    /// A connection that was made; `None`: there is no place for it.
    pub fn connect(&mut self) -> Option<Key> {
        let key = self.pages.connect()?;
        self.pages.begin(key, self.now);
        self.sent.insert(key, VecDeque::new());
        self.settle();
        Some(key)
    }

    /// A page that has shown the token.
    pub fn known(&mut self) -> Key {
        let key = self.connect().expect("a place");
        let token = serde_json::json!({"token": self.token});
        self.say(key, &token);
        key
    }

    /// A page says something.
    pub fn say(&mut self, key: Key, message: &Value) {
        self.hear(key, PageEvent::Text(&message.to_string()));
    }

    pub fn hear(&mut self, key: Key, heard: PageEvent<'_>) {
        self.pages.hear(key, self.now, heard);
        self.settle();
    }

    /// Does what is to be done, and sends what is to be sent, at this time; when there will be more.
    pub fn settle(&mut self) -> Option<Duration> {
        let mut due = self.pages.look(self.now);
        for action in self.pages.actions() {
            self.act(action);
        }
        let keys: Vec<Key> = self.sent.keys().copied().filter(|key| !self.closed.contains_key(key)).collect();
        for key in keys {
            let mut last = None;
            loop {
                let Some(next) = self.pages.poll(key, self.now) else {
                    self.closed.insert(key, (self.now, last));
                    break;
                };
                match next.send {
                    Some(Outgoing::Text(text)) => {
                        let text = serde_json::from_str(&text).expect("JSON");
                        self.sent.entry(key).or_default().push_back(text);
                    }
                    Some(Outgoing::Close(why)) => last = Some(why),
                    None => {
                        due = due.into_iter().chain(next.until).min();
                        break;
                    }
                }
                if !self.stuck.contains(&key) {
                    self.pages.sent(key);
                }
            }
        }
        // The end of a page may leave something to be done.
        let actions = self.pages.actions();
        if actions.is_empty() {
            return due;
        }
        for action in actions {
            self.act(action);
        }
        self.settle()
    }

    fn act(&mut self, action: Action) {
        match action {
            Action::Say(text) => self.said.push(text),
            Action::Ask { request, by, to } => {
                assert_eq!(u128::from(by.heard), self.now.as_nanos());
                self.ask(request, to);
            }
            Action::Files { asked, shown, to } => match &self.poses {
                None => self.work.push_back((to, asked, shown)),
                poses => {
                    let (outcome, taught) = teaching::carry_out(poses.as_ref(), &self.looks, &asked, &shown);
                    self.pages.worked(to, outcome, taught);
                }
            },
        }
    }

    fn ask(&mut self, request: Request, to: Option<To>) {
        self.asked.push_back((self.now, request));
        match ((self.answers)(&request), to) {
            (Some(answer), Some(to)) => self.pages.answered(to, &request, Some(answer)),
            (None, Some(to)) => self.waiting.push_back((to, request)),
            (_, None) => {}
        }
    }

    /// Time passes; what is due meanwhile happens when it is.
    pub fn pass(&mut self, time: Duration) {
        let until = self.now + time;
        while let Some(due) = self.settle().filter(|due| *due <= until) {
            assert!(due > self.now, "what is due now is done");
            self.now = due;
        }
        self.now = until;
        self.settle();
    }

    /// The next request that the console server was asked for.
    pub fn request(&mut self) -> Option<Request> {
        self.asked.pop_front().map(|(_, request)| request)
    }

    /// The next message to a page; `None`: there is none.
    pub fn next(&mut self, key: Key) -> Option<Value> {
        self.sent.get_mut(&key)?.pop_front()
    }

    /// The answer of a number.
    pub fn answer(&mut self, key: Key, number: u64) -> Value {
        loop {
            let message = self.next(key).expect("answered");
            if message["kind"] == "answer" && message["n"] == number {
                return message;
            }
        }
    }

    /// The kinds of all messages to a page that it has not heard.
    pub fn kinds(&mut self, key: Key) -> Vec<String> {
        std::iter::from_fn(|| self.next(key))
            .map(|message| message["kind"].as_str().expect("a kind").to_owned())
            .collect()
    }
}
