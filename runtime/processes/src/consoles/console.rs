//! One console, as the console server holds it.
//!
//! In: bytes, as they come. Out: requests, one at a time: the next request is read when the one before is answered, so
//! that requests of a console that asks too fast stay in its own socket and take none of the launcher's memory.

use std::io::{self, ErrorKind, Read, Write};
use std::os::fd::{AsFd, BorrowedFd};
use std::os::unix::net::UnixStream;
use std::time::Instant;

use super::protocol::{MAX_ANSWER, MAX_REQUEST};
use crate::link::monotonic;
use mrroc_core::observe::recording::Command;
use mrroc_core::operator::button::Button;
use mrroc_core::operator::request::Addressed;
use mrroc_core::operator::{Answer, OnBehalf, Request};

/// The request of a console that has not been answered yet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum PendingRequest {
    Nothing,
    /// A button, while another press of its kind is under way.
    Press(Button),
    /// The result of the press of this kind and number.
    Answer(usize, u64),
}

/// A console.
pub(super) struct Console {
    /// Its ordinal among all consoles of the session.
    pub id: u64,
    pub pid: u32,
    pub asked: PendingRequest,
    /// Which MP its last request is for, and which one it watches, by the places of their sessions.
    pub session: usize,
    pub watched: usize,
    /// When it gets its next picture, if it watches.
    pub watches: Option<Instant>,
    /// Whether it is served; one that waits for a place may only stop the cell.
    pub is_served: bool,
    /// Whether it has sent a request.
    pub has_asked: bool,
    /// When it connected.
    pub since: Instant,
    /// Whether it has gone or is to be disconnected.
    pub gone: bool,
    /// The command that waits for its answer, and those that have got it since the last round, for the recording.
    command: Option<Command>,
    commands: Vec<Command>,
    stream: UnixStream,
    input: Vec<u8>,
    /// Whether it has closed its sending direction.
    silent: bool,
    output: Vec<u8>,
}

impl Console {
    /// # Errors
    /// The stream cannot be used.
    pub fn new(id: u64, pid: u32, stream: UnixStream) -> io::Result<Console> {
        stream.set_nonblocking(true)?;
        Ok(Console {
            id,
            pid,
            asked: PendingRequest::Nothing,
            session: 0,
            watched: 0,
            watches: None,
            is_served: false,
            has_asked: false,
            since: Instant::now(),
            gone: false,
            command: None,
            commands: Vec::new(),
            stream,
            input: Vec::with_capacity(MAX_REQUEST + 1),
            silent: false,
            output: Vec::new(),
        })
    }

    /// The file descriptor of the connection.
    pub fn descriptor(&self) -> BorrowedFd<'_> {
        self.stream.as_fd()
    }

    /// Whether to wait until it sends something.
    pub fn is_listened_to(&self) -> bool {
        self.asked == PendingRequest::Nothing && !self.silent && !self.has_line()
    }

    /// Whether to wait until it can take more text.
    pub const fn is_written_to(&self) -> bool {
        !self.output.is_empty()
    }

    /// Whether a request has come that has not been read yet.
    pub fn has_line(&self) -> bool {
        self.input.contains(&b'\n')
    }

    /// Reads what has come, at most as much as the longest request.
    pub fn read(&mut self) {
        let mut bytes = [0; MAX_REQUEST + 1];
        let room = bytes.len() - self.input.len().min(bytes.len());
        match self.stream.read(&mut bytes[..room]) {
            Ok(0) if room > 0 => self.silent = true,
            Ok(count) => self.input.extend_from_slice(&bytes[..count]),
            Err(error) if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::Interrupted) => {}
            Err(_) => self.gone = true,
        }
    }

    /// The next request, without its line end, if the one before is answered.
    pub fn line(&mut self) -> Option<String> {
        if self.asked != PendingRequest::Nothing || self.is_written_to() {
            return None;
        }
        if let Some(end) = self.input.iter().position(|&byte| byte == b'\n') {
            let mut line: Vec<_> = self.input.drain(..=end).collect();
            line.pop();
            self.has_asked = true;
            return Some(String::from_utf8_lossy(&line).into_owned());
        }
        if self.input.len() > MAX_REQUEST {
            self.answer(&Answer::Refused(format!("no request has more than {MAX_REQUEST} bytes")));
            self.silent = true;
            self.input.clear();
        }
        None
    }

    /// Notes a command that it gives, for the recording.
    pub fn gives(&mut self, Addressed { by, cell, request }: &Addressed) {
        let now = monotonic();
        let (by, asked) = match by {
            // No page is heard in the future.
            Some(OnBehalf { page, heard }) => {
                (format!("page {page} of process {}", self.pid), (*heard).min(now))
            }
            None => (format!("process {}", self.pid), now),
        };
        self.command = match request {
            Request::Status | Request::Watch => None,
            Request::Take | Request::Release | Request::Press(_) => Some(Command {
                asked,
                answered: now,
                by,
                cell: *cell,
                command: request.to_string(),
                outcome: "unanswered",
                answer: String::new(),
            }),
        };
    }

    /// The commands that were answered, or will not be.
    pub fn take_commands(&mut self) -> impl Iterator<Item = Command> {
        let unanswered = if self.gone { self.command.take() } else { None };
        core::mem::take(&mut self.commands).into_iter().chain(unanswered)
    }

    /// Answers its request.
    pub fn answer(&mut self, answer: &Answer) {
        if let Some(command) = self.command.take() {
            let (outcome, text) = answer.parts();
            self.commands.push(Command {
                answered: monotonic(),
                outcome,
                answer: text.to_owned(),
                ..command
            });
        }
        self.asked = PendingRequest::Nothing;
        self.write(&format!("{answer}\n"));
    }

    /// Answers for the last time: it is disconnected once it has got the answer.
    pub fn dismiss(&mut self, answer: &Answer) {
        self.watches = None;
        self.silent = true;
        self.input.clear();
        self.answer(answer);
    }

    /// Writes to it; disconnects it if too much text is unread.
    pub fn write(&mut self, text: &str) {
        self.output.extend_from_slice(text.as_bytes());
        self.flush();
        self.gone |= self.output.len() > MAX_ANSWER;
    }

    /// Writes as much of the waiting text as the socket takes.
    pub fn flush(&mut self) {
        while !self.output.is_empty() {
            match self.stream.write(&self.output) {
                Ok(count) => drop(self.output.drain(..count)),
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(error) if error.kind() == ErrorKind::WouldBlock => return,
                Err(_) => {
                    self.gone = true;
                    return;
                }
            }
        }
    }

    /// Whether it can be removed: it has gone, or it has sent its last request and got the answer.
    pub fn is_over(&self) -> bool {
        let answered = self.asked == PendingRequest::Nothing && !self.is_written_to() && !self.has_line();
        self.gone || (self.silent && answered && self.watches.is_none())
    }
}
