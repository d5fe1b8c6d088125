//! How the drives are opened: the first message of the controller, and, with relative corrections, when it counts a late answer.
//!
//! In: the time, and what the controller says. Out: what it is answered, and a session. One of its messages is left
//! unanswered, while nothing moves, to see in which of the next ones that is counted. Nothing here has a clock or a socket.

use core::time::Duration;
use std::net::SocketAddr;

use mrroc::robot::{DriveFault, RobotStop, StopCause};

use crate::corrections::{Corrections, Counts, Sum};
use crate::message::FromController;
use crate::session::{Sent, Session};
use crate::settings::RsiSettings;
use crate::words::Words;

pub(crate) const SILENT: DriveFault = DriveFault::Stopped(
    RobotStop::new(StopCause::ProgramNotRunning).named("the controller sends nothing").at_pendant(),
);
pub(crate) const NO_DELAY: DriveFault =
    DriveFault::Other("relative corrections need its count of late answers: let it send DEF_Delay");
pub(crate) const NO_COUNT: DriveFault = DriveFault::Other(
    "relative corrections need its count of late answers, and it does not count one that is left out: write corrections = \"absolute\"",
);

/// How often it is tried to find out when the controller counts a late answer: it may be late by itself meanwhile.
const TRIALS: u32 = 10;

/// How long to wait for the first message, and then for all others until it is known when it counts a late answer.
pub(crate) const TIMEOUT: Duration = Duration::from_secs(2);

/// Drives that are being opened.
#[derive(Debug)]
pub(crate) struct Opening {
    until: Duration,
    session: Option<(Session, Trials)>,
}

/// What is to be done after a look.
#[derive(Debug)]
pub(crate) struct Step {
    /// What is to be sent, before anything else.
    pub sent: Option<Sent>,
    /// The session, when the drives are open; `None` while the next message is waited for; or why they cannot be opened.
    pub outcome: Result<Option<Box<Session>>, DriveFault>,
}

impl Opening {
    /// From this time on.
    pub fn new(now: Duration) -> Opening {
        Opening { until: now + TIMEOUT, session: None }
    }

    /// Goes on at this time, with a message if one has come. They cannot be opened where the controller says nothing, or not what is needed
    /// of its outputs or of late answers.
    pub fn poll(
        &mut self,
        now: Duration,
        heard: Option<(FromController, SocketAddr)>,
        settings: &RsiSettings,
        words: &mut Words,
    ) -> Step {
        let mut sent = None;
        let outcome = match heard {
            _ if now >= self.until => Err(SILENT),
            None => Ok(None),
            Some(heard) => self.hear(now, heard, settings, words, &mut sent),
        };
        Step { sent, outcome }
    }

    fn hear(
        &mut self,
        now: Duration,
        (said, from): (FromController, SocketAddr),
        settings: &RsiSettings,
        words: &mut Words,
        sent: &mut Option<Sent>,
    ) -> Result<Option<Box<Session>>, DriveFault> {
        let Some((session, trials)) = &mut self.session else {
            let mut session = Session::new(settings, now, said, from);
            words.begin(&said)?;
            *sent = session.answer(words.word())?;
            if settings.corrections == Corrections::Absolute {
                return Ok(Some(Box::new(session)));
            }
            self.until = now + TIMEOUT;
            self.session = Some((session, Trials::default()));
            return Ok(None);
        };
        let is_next = session.is_next(&said);
        session.hear(now, said, from);
        if trials.answers() {
            *sent = session.answer(words.word())?;
        }
        let late = said.late.ok_or(NO_DELAY)?;
        let Some(counts) = trials.take(is_next.then_some(late))? else { return Ok(None) };
        session.sum = Sum::new(settings.corrections, counts);
        session.begin();
        Ok(self.session.take().map(|(session, _)| Box::new(session)))
    }
}

/// Finds out when the controller counts a late answer: of four messages, one after the other, the second is left unanswered.
#[derive(Debug, Default)]
struct Trials {
    number: u32,
    /// How many answers are late by each of the messages of this trial; `None` for one that was not the next.
    late: [Option<u64>; 4],
    heard: usize,
}

impl Trials {
    /// Whether the next message is answered.
    fn answers(&self) -> bool {
        self.heard != 1
    }

    /// The next message says that so many answers are late; `None`: it was not the next one. When they are counted, if that is known by now.
    ///
    /// # Errors
    /// No trial has shown that.
    fn take(&mut self, late: Option<u64>) -> Result<Option<Counts>, DriveFault> {
        self.late[self.heard] = late;
        self.heard += 1;
        let is_spoilt = self.heard == 2 && late.is_none();
        if self.heard < self.late.len() && !is_spoilt {
            return Ok(None);
        }
        let counts = if is_spoilt { None } else { counts(self.late) };
        (self.heard, self.number) = (0, self.number + 1);
        if counts.is_none() && self.number == TRIALS { Err(NO_COUNT) } else { Ok(counts) }
    }
}

/// What four messages in a row show, the second of which was not answered. Whatever else was late meanwhile says nothing.
fn counts(late: [Option<u64>; 4]) -> Option<Counts> {
    let [Some(before), Some(left_out), Some(once), Some(twice)] = late else { return None };
    if before != left_out {
        None
    } else if once == left_out + 1 && twice <= once {
        Some(Counts::AtOnce)
    } else if once == left_out && twice == once + 1 {
        Some(Counts::Later)
    } else {
        None
    }
}
