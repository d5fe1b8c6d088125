//! A process's end of the socket.
//!
//! In: what the process shows. Out: datagrams to the plant, from a thread that may wait for it.

use std::io;
use std::os::unix::net::UnixDatagram;
use std::path::{Path, PathBuf};
use std::rc::Rc;
use std::sync::Arc;
use std::time::Duration;

use mrroc_core::console::complain;
use mrroc_core::fault::{ProcessId, Role};
use mrroc_core::link::Clock;
use mrroc_core::observe::ring::{Record, Ring, RingError, RingUse, Sink};
use mrroc_core::observe::step_observer::StepEvent;

use super::datagram::{self, TIMEOUT, socket};

/// Number of records that the ring holds: those of a quarter of a second of an MP with three sensors at 1 kHz.
const LENGTH: usize = 1024;

/// How long the thread sleeps when there is nothing to send.
const REST: Duration = Duration::from_millis(10);

/// Stack of the thread \[bytes\].
const STACK: usize = 64 << 10;

/// The number of words from which on a datagram is sent.
const FULL: usize = 1024;

/// Begins to send what a process shows to the plant of its session; `None` of a process that shows a picture nothing.
pub(crate) fn join(process: ProcessId, folder: &Path, clock: Clock) -> Option<Rc<Ring>> {
    let shows = match process.role {
        Role::Mp | Role::Ecp | Role::Edp => true,
        Role::Vsp | Role::Plant | Role::Node => false,
    };
    if !shows {
        return None;
    }
    let begun = send(socket(folder), clock, TIMEOUT);
    let unseen = |error: &io::Error| complain(&format!("warning: {process}: not in the picture: {error}"));
    begun.map(Rc::new).inspect_err(unseen).ok()
}

/// Begins to send what is seen to the socket at `path`.
pub(super) fn send(path: PathBuf, clock: Clock, timeout: Duration) -> io::Result<Ring> {
    let about = RingUse {
        length: LENGTH,
        clock,
        rest: REST,
        flush: Duration::ZERO,
        timeout,
        stack: STACK,
        is_asked_for: Box::new(|_, what: &StepEvent| datagram::is_needed(what)),
        // What is lost is told by the plant. A plant that is gone ends the cell, and draws no picture.
        tell: Arc::new(|_: &RingError| {}),
    };
    let datagrams = Datagrams { path, socket: None, words: Vec::new(), bytes: Vec::new() };
    let open = move || Ok(Box::new(datagrams) as Box<dyn Sink>);
    Ring::begin("picture", about, Box::new(open))
}

/// Sends records as datagrams.
struct Datagrams {
    path: PathBuf,
    /// Connected before the first datagram is sent: the plant has made the socket before the cell begins.
    socket: Option<UnixDatagram>,
    words: Vec<u64>,
    bytes: Vec<u8>,
}

impl Datagrams {
    fn send(&mut self) -> io::Result<()> {
        let socket = match self.socket.take() {
            Some(socket) => socket,
            None => {
                let socket = UnixDatagram::unbound()?;
                socket.connect(&self.path)?;
                socket
            }
        };
        self.bytes.clear();
        self.bytes.extend(self.words.drain(..).flat_map(u64::to_le_bytes));
        let sent = loop {
            match socket.send(&self.bytes) {
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                sent => break sent,
            }
        };
        self.socket = Some(socket);
        sent.map(drop)
    }
}

impl Sink for Datagrams {
    fn put(&mut self, record: &Record) -> io::Result<()> {
        datagram::put(&mut self.words, record);
        if self.words.len() < FULL { Ok(()) } else { self.send() }
    }

    fn flush(&mut self) -> io::Result<()> {
        if self.words.is_empty() { Ok(()) } else { self.send() }
    }

    fn finish(&mut self, dropped: u64) -> io::Result<()> {
        datagram::put_end(&mut self.words, dropped);
        self.send()
    }
}
