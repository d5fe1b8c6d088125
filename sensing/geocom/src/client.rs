//! What is asked of an instrument, and what it answers: one question at a time.
//!
//! In: what is to be done, the time, and bytes that have come. Out: bytes to send, how long to wait, and in the end what was measured. Nothing here
//! reads a clock or touches a port: the time is any that goes on evenly, counted from any beginning. [`Connection`](crate::Connection) does this over a
//! serial port.

use core::time::Duration;

use crate::action::{ClientAction, GeocomError, Measured};
use crate::angles::{Face, from_circles, to_circles};
use crate::exchange::{Exchange, Progress};
use crate::framing::Lines;
use crate::protocol::{Answer, Request};

/// How long answers are waited for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Timeouts {
    /// Where nothing turns; 3 s.
    pub answer: Duration,
    /// Where the instrument turns to a target; 30 s.
    pub turn: Duration,
    /// How often it is asked at most; 3.
    pub times: u32,
}

impl Default for Timeouts {
    fn default() -> Self {
        Self { answer: Duration::from_secs(3), turn: Duration::from_secs(30), times: 3 }
    }
}

/// Who asks.
///
/// ```
/// use core::time::Duration;
/// use mrroc_geocom::{Client, ClientAction, Timeouts, GeocomError};
///
/// let mut client = Client::new(Timeouts { times: 1, ..Timeouts::default() });
/// client.greet();
/// let second = Duration::from_secs;
/// assert_eq!(client.poll(second(5), &[]), ClientAction::Receive { until: second(5) });
/// assert_eq!(client.poll(second(5), &[]), ClientAction::Send { until: second(7) });
/// assert_eq!(client.outgoing(), b"%R1Q,0,1:\r\n");
/// client.sent(client.outgoing().len());
/// assert_eq!(client.poll(second(5), &[]), ClientAction::Receive { until: second(8) });
/// assert_eq!(client.poll(second(8), &[]), ClientAction::Done(Err(GeocomError::Silent)));
/// ```
#[derive(Debug)]
pub struct Client {
    timeout: Timeouts,
    transaction: u32,
    /// Whether the instrument knows checksums; `None` before its first answer.
    checks: Option<bool>,
    lines: Lines,
    outgoing: Vec<u8>,
    work: Option<Work>,
}

/// What is being done.
#[derive(Debug)]
struct Work {
    question: Question,
    /// How often it was asked before.
    tried: u32,
    exchange: Exchange,
}

/// The question that is asked, and what it is asked for.
#[derive(Clone, Copy, Debug)]
enum Question {
    /// Whether it answers.
    Greeting,
    /// In which face the telescope is, after it was turned over so many times.
    Face { target: Target, turned: u32 },
    /// To turn it over.
    TurnOver { target: Target, turned: u32 },
    /// To turn to the target.
    Turn(Target),
    /// What the circles read; in the face that was asked for, if one was.
    Angles(Option<Face>),
}

/// Where a target is about, and in which face it is to be sighted.
#[derive(Clone, Copy, Debug)]
struct Target {
    about: [f64; 2],
    face: Face,
}

/// What follows an answer.
enum Then {
    Ask(Question),
    Done(Result<Option<Measured>, GeocomError>),
}

impl Client {
    /// Nothing is asked for yet.
    #[must_use]
    pub const fn new(timeout: Timeouts) -> Self {
        Self { timeout, transaction: 0, checks: None, lines: Lines::new(), outgoing: Vec::new(), work: None }
    }

    /// Begins to ask whether the instrument answers (`COM_NullProc`). What was being done is given up.
    pub fn greet(&mut self) {
        self.begin(Question::Greeting);
    }

    /// Begins to turn the telescope over if need be, then about to these angles (horizontal from x to y, and elevation \[rad\]), to let the instrument
    /// find the target there, and to measure. What was being done is given up.
    pub fn sight(&mut self, about: [f64; 2], face: Face) {
        self.begin(Question::Face { target: Target { about, face }, turned: 0 });
    }

    /// Begins to measure where the telescope points, with the compensator (`TMC_GetAngle1`). What was being done is given up.
    pub fn measure(&mut self) {
        self.begin(Question::Angles(None));
    }

    /// What is to be sent.
    #[must_use]
    pub fn outgoing(&self) -> &[u8] {
        &self.outgoing
    }

    /// So many bytes of what was outgoing have been sent.
    pub fn sent(&mut self, count: usize) {
        self.outgoing.drain(..count.min(self.outgoing.len()));
    }

    /// Goes on at a time with the bytes that have come since the last call.
    pub fn poll(&mut self, now: Duration, bytes: &[u8]) -> ClientAction {
        let Some(mut work) = self.work.take() else { return ClientAction::Idle };
        self.lines.push(bytes);
        let is_quiet = bytes.is_empty();
        loop {
            let (lines, outgoing) = (&mut self.lines, &mut self.outgoing);
            let answer = match work.exchange.poll(now, is_quiet, lines, outgoing, &mut self.checks) {
                Progress::On(next) => {
                    self.work = Some(work);
                    return next;
                }
                Progress::Over(answer) => answer,
            };
            work.tried += 1;
            if self.asks_again(&work, &answer) {
                work.exchange = self.exchange(work.question, work.tried);
                continue;
            }
            match self.after(work.question, answer) {
                Then::Ask(question) => work = self.work_on(question),
                Then::Done(outcome) => return ClientAction::Done(outcome),
            }
        }
    }

    fn begin(&mut self, question: Question) {
        self.outgoing.clear();
        self.work = Some(self.work_on(question));
    }

    fn work_on(&mut self, question: Question) -> Work {
        Work { question, tried: 0, exchange: self.exchange(question, 0) }
    }

    /// Asks a question that was asked so many times before. Where it is not known whether the instrument knows checksums, that is found out by one; but
    /// not with the last try, for an instrument that does not answer to one.
    fn exchange(&mut self, question: Question, tried: u32) -> Exchange {
        self.transaction = (self.transaction + 1) % 8;
        let guess = question.is_asked_once() || tried + 1 < self.timeout.times.max(1);
        let checked = self.checks.unwrap_or(guess);
        let (rpc, parameters) = question.call();
        let timeout = if question.turns() { self.timeout.turn } else { self.timeout.answer };
        Exchange::of(Request { rpc, transaction: self.transaction, checked, parameters }, timeout)
    }

    /// Whether a question is asked again: after silence, after an answer that cannot be understood, and while the instrument is busy.
    fn asks_again(&self, work: &Work, answer: &Result<Answer, GeocomError>) -> bool {
        work.tried < self.timeout.times.max(1)
            && !work.question.is_asked_once()
            && answer.as_ref().is_err_and(|trouble| trouble.is_passing())
    }

    /// What follows the answer to a question.
    fn after(&self, question: Question, answer: Result<Answer, GeocomError>) -> Then {
        match (question, answer) {
            (Question::TurnOver { .. }, Err(trouble)) if !trouble.is_passing() => Then::Done(Err(trouble)),
            // Its face says what became of it.
            (Question::TurnOver { target, turned }, _) if turned + 1 < self.timeout.times => {
                Then::Ask(Question::Face { target, turned: turned + 1 })
            }
            (Question::TurnOver { target, .. }, _) => Then::Ask(Question::Turn(target)),
            (_, Err(trouble)) => Then::Done(Err(trouble)),
            (Question::Greeting, Ok(_)) => Then::Done(Ok(None)),
            (Question::Face { target, turned }, Ok(answer)) => match face_of(answer.number(0)) {
                Ok(face) if face == target.face => Then::Ask(Question::Turn(target)),
                Ok(_) => Then::Ask(Question::TurnOver { target, turned }),
                Err(trouble) => Then::Done(Err(trouble)),
            },
            (Question::Turn(target), Ok(_)) => Then::Ask(Question::Angles(Some(target.face))),
            (Question::Angles(asked), Ok(answer)) => Then::Done(measured(&answer, asked).map(Some)),
        }
    }
}

impl Question {
    /// The procedure, and what it is given.
    fn call(self) -> (u32, Vec<f64>) {
        match self {
            Self::Greeting => (0, Vec::new()),
            Self::Face { .. } => (2026, Vec::new()),
            Self::TurnOver { .. } => (9028, vec![0.0, 0.0, 0.0]),
            Self::Turn(Target { about, face }) => {
                let [hz, v] = to_circles(about, face);
                // Position mode: normal; with target recognition.
                (9027, vec![hz, v, 0.0, 1.0, 0.0])
            }
            Self::Angles(_) => (2003, vec![0.0]),
        }
    }

    /// Whether the instrument turns before it answers.
    const fn turns(self) -> bool {
        matches!(self, Self::TurnOver { .. } | Self::Turn(_))
    }

    /// It turns the telescope over each time, so it is asked again only where the face says that it has not.
    const fn is_asked_once(self) -> bool {
        matches!(self, Self::TurnOver { .. })
    }
}

fn measured(answer: &Answer, asked: Option<Face>) -> Result<Measured, GeocomError> {
    let (hz, v) = answer.number(0).zip(answer.number(1)).ok_or(GeocomError::Garbled)?;
    let face = face_of(answer.number(8))?;
    if asked.is_some_and(|asked| asked != face) {
        return Err(GeocomError::OtherFace);
    }
    Ok(Measured { angles: from_circles([hz, v], face), face })
}

fn face_of(number: Option<f64>) -> Result<Face, GeocomError> {
    match number {
        Some(0.0) => Ok(Face::One),
        Some(1.0) => Ok(Face::Two),
        _ => Err(GeocomError::Garbled),
    }
}
