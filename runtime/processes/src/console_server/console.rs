//! One console, as the server of its cell sees it.
//!
//! In: bytes, as they come. Out: requests, one at a time: the next one is read when the one before is answered, so that a
//! console that asks more than can be answered waits in its own socket and in nobody's memory.

use std::io::{self, ErrorKind, Read, Write};
use std::os::fd::{AsFd, BorrowedFd};
use std::os::unix::net::UnixStream;
use std::time::Instant;

use super::protocol::{MAX_REQUEST, Reply};
use mrroc_core::operator::button::Button;

/// Bytes that may wait for a console to read them.
const MAX_OUTPUT: usize = 1 << 16;

/// What a console has asked and not been answered.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Asked {
    Nothing,
    /// A button, whose kind is in use.
    Press(Button),
    /// What becomes of the press of this kind and number.
    Answer(usize, u64),
}

/// A console.
pub(super) struct Console {
    /// Which one it is, among all that there were; the process that it is.
    pub id: u64,
    pub pid: u32,
    pub asked: Asked,
    /// When it is due its next picture, if it watches.
    pub watches: Option<Instant>,
    /// It has gone, or is to.
    pub gone: bool,
    stream: UnixStream,
    input: Vec<u8>,
    /// It says nothing more.
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
            asked: Asked::Nothing,
            watches: None,
            gone: false,
            stream,
            input: Vec::with_capacity(MAX_REQUEST + 1),
            silent: false,
            output: Vec::new(),
        })
    }

    /// What to wait on.
    pub fn descriptor(&self) -> BorrowedFd<'_> {
        self.stream.as_fd()
    }

    /// Whether to wait for it to say something.
    pub fn is_listened_to(&self) -> bool {
        self.asked == Asked::Nothing && !self.silent && !self.has_line()
    }

    /// Whether to wait for it to read something.
    pub const fn is_written_to(&self) -> bool {
        !self.output.is_empty()
    }

    /// Whether a request is here that has not been looked at.
    pub fn has_line(&self) -> bool {
        self.input.contains(&b'\n')
    }

    /// Reads what has come, no more than one request is long.
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

    /// The next request, without its end, if the one before is answered.
    pub fn line(&mut self) -> Option<Vec<u8>> {
        if self.asked != Asked::Nothing || self.is_written_to() {
            return None;
        }
        if let Some(end) = self.input.iter().position(|&byte| byte == b'\n') {
            let mut line: Vec<_> = self.input.drain(..=end).collect();
            line.pop();
            return Some(line);
        }
        if self.input.len() > MAX_REQUEST {
            self.answer(&Reply::Refused(format!("no request has more than {MAX_REQUEST} bytes")));
            self.silent = true;
            self.input.clear();
        }
        None
    }

    /// Answers what it asked.
    pub fn answer(&mut self, reply: &Reply) {
        self.asked = Asked::Nothing;
        self.write(&format!("{reply}\n"));
    }

    /// Writes to it; whoever does not read is left.
    pub fn write(&mut self, text: &str) {
        self.output.extend_from_slice(text.as_bytes());
        self.flush();
        self.gone |= self.output.len() > MAX_OUTPUT;
    }

    /// Writes what is left as far as it goes.
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

    /// Whether nothing more is to be done for it: it has gone, or has said its last and been answered.
    pub fn is_over(&self) -> bool {
        let answered = self.asked == Asked::Nothing && !self.is_written_to() && !self.has_line();
        self.gone || (self.silent && answered && self.watches.is_none())
    }
}
