//! One question and its answer.
//!
//! In: the time, and lines that have come. Out: a line to send, how long to wait, and in the end an answer, or why there is none.

use core::time::Duration;

use crate::action::{ClientAction, GeocomError};
use crate::framing::Lines;
use crate::protocol::{Answer, Code, Request};

/// Lines that are thrown away before a question, and answers to others that are passed over after it: more is no instrument.
const MOST_BEFORE: usize = 64;
const MOST_OTHERS: usize = 8;

/// How long a line may take to be sent.
const SEND: Duration = Duration::from_secs(2);

/// A question that is being asked.
#[derive(Debug)]
pub struct Exchange {
    request: Request,
    timeout: Duration,
    state: State,
}

#[derive(Debug)]
enum State {
    /// What came before the question is thrown away: it is no answer to it. Whether what is there was read.
    Clearing { passed: usize, is_read: bool },
    /// The question is being sent, until then at most.
    Sending { until: Duration },
    /// Its answer is waited for, until then at most.
    Waiting { until: Duration, others: usize },
}

/// What becomes of an exchange.
pub enum Progress {
    /// It goes on when this is done.
    On(ClientAction),
    /// It is over.
    Over(Result<Answer, GeocomError>),
}

/// What a line is to a question.
enum Heard {
    /// The answer to another one.
    Other,
    /// The answer, or what stands in its place.
    Answer(Result<Answer, GeocomError>),
}

impl Exchange {
    /// Asks this, and waits so long for each line that comes.
    pub const fn of(request: Request, timeout: Duration) -> Self {
        Self { request, timeout, state: State::Clearing { passed: 0, is_read: false } }
    }

    /// Goes on with it. `is_quiet` says that nothing has come since the last time. `checks` says whether the instrument knows checksums, which an
    /// answer tells.
    pub fn poll(
        &mut self,
        now: Duration,
        mut is_quiet: bool,
        lines: &mut Lines,
        outgoing: &mut Vec<u8>,
        checks: &mut Option<bool>,
    ) -> Progress {
        loop {
            match &mut self.state {
                State::Clearing { passed, is_read } => {
                    match lines.next_line() {
                        Err(trouble) => return Progress::Over(Err(trouble)),
                        Ok(Some(_)) => {
                            *passed += 1;
                            if *passed > MOST_BEFORE {
                                return Progress::Over(Err(GeocomError::Garbled));
                            }
                            continue;
                        }
                        Ok(None) => {}
                    }
                    // More may have come that nobody has read yet.
                    if !(*is_read && is_quiet) {
                        *is_read = true;
                        return Progress::On(ClientAction::Receive { until: now });
                    }
                    *outgoing = format!("{}\r\n", self.request).into_bytes();
                    self.state = State::Sending { until: now + SEND };
                }
                State::Sending { .. } if outgoing.is_empty() => {
                    self.state = State::Waiting { until: now + self.timeout, others: 0 };
                    is_quiet = false;
                }
                State::Sending { until } => {
                    if now < *until {
                        return Progress::On(ClientAction::Send { until: *until });
                    }
                    outgoing.clear();
                    return Progress::Over(Err(GeocomError::Silent));
                }
                State::Waiting { until, others } => {
                    let line = match lines.next_line() {
                        Err(trouble) => return Progress::Over(Err(trouble)),
                        // What has come by the end of the time is read, however late it is looked at.
                        Ok(None) if is_quiet && now >= *until => {
                            return Progress::Over(Err(GeocomError::Silent));
                        }
                        Ok(None) => return Progress::On(ClientAction::Receive { until: *until }),
                        Ok(Some(line)) => line,
                    };
                    match heard(&line, self.request.transaction, checks) {
                        Heard::Answer(answer) => return Progress::Over(answer),
                        Heard::Other => {
                            (*until, *others) = (now + self.timeout, *others + 1);
                            if *others == MOST_OTHERS {
                                return Progress::Over(Err(GeocomError::Silent));
                            }
                        }
                    }
                }
            }
        }
    }
}

/// What a line is to the question of a transaction. An answer to an earlier question is not taken, nor one without a checksum of an instrument that
/// knows them.
fn heard(line: &str, transaction: u32, checks: &mut Option<bool>) -> Heard {
    let Some(answer) = Answer::parse(line) else { return Heard::Answer(Err(GeocomError::Garbled)) };
    // What an instrument could not read it may answer without a number.
    if answer.transaction != transaction && (answer.transport == Code::OK || answer.transaction != 0) {
        return Heard::Other;
    }
    if answer.transport == Code::OK {
        checks.get_or_insert(answer.checked);
    }
    if *checks == Some(true) && !answer.checked || answer.transport.is_of_lines() {
        return Heard::Answer(Err(GeocomError::Garbled));
    }
    Heard::Answer(match (answer.transport, answer.code) {
        (Code::OK, Code::OK) => Ok(answer),
        (Code::OK, code) | (code, _) => Err(GeocomError::Refused(code)),
    })
}
