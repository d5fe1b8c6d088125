//! The recording of a cell that runs as processes: each process sends its messages to the launcher, which writes the
//! file.
//!
//! In: messages, from the recorder's thread of each process. Out: one file, which is kept even if a process dies, as
//! long as the launcher lives. The messages go through a datagram socket in the session's folder, each of them
//! whole, in the order in which a process sends them. When the socket is full, the recorder's thread waits, and the
//! step is not delayed.

#![expect(clippy::disallowed_methods, reason = "the launcher's thread, which is no part of control")]

use std::io::{self, ErrorKind};
use std::os::unix::net::UnixDatagram;
use std::path::{Path, PathBuf};
use std::rc::Rc;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use super::channels::Outlet;
use super::file::{McapFile, REAL_TIME, can_be_written, write_timeout};
use super::ring;
use mrroc_core::console::complain;
use mrroc_core::fault::{ProcessId, Role};
use mrroc_core::link::Clock;
use mrroc_core::link::Nanos;
use mrroc_core::observe::layout::Layout;
use mrroc_core::observe::recording::{NotRecorded, Recording};
use mrroc_core::observe::ring::Ring;

/// The longest message \[bytes\]; usual messages have some thousand bytes.
const LONGEST: usize = 128 * 1024;

/// How often the launcher's thread checks whether the recording is to end.
const REST: Duration = Duration::from_millis(50);

/// The path of a session's socket, whose name says by which clock its processes run.
pub(super) fn socket(folder: &Path, clock: Clock) -> PathBuf {
    folder.join(match clock {
        Clock::Real => "record.real",
        Clock::Virtual => "record.virtual",
    })
}

/// Joins the recording of a session; `None` if the session is not recorded or this process has nothing to show.
pub(crate) fn join(
    recording: Option<&Recording>,
    layout: &Layout,
    process: ProcessId,
    folder: &Path,
) -> Option<Rc<Ring>> {
    let shows = match process.role {
        Role::Mp | Role::Ecp | Role::Edp => true,
        Role::Plant => !layout.bodies.is_empty(),
        Role::Vsp | Role::Node => false,
    };
    if !shows {
        return None;
    }
    let (path, clock) = [Clock::Real, Clock::Virtual]
        .map(|clock| (socket(folder, clock), clock))
        .into_iter()
        .find(|(path, _)| path.exists())?;
    let recording = recording.cloned().unwrap_or_else(|| Recording::to("the recording"));
    let open = Box::new(move || {
        let socket = UnixDatagram::unbound()?;
        socket.connect(&path)?;
        Ok(Box::new(Sender::to(socket)) as Box<dyn Outlet>)
    });
    // A process that cannot record runs without being recorded.
    let begun = ring::begin(&recording, recording.of(layout.clone()), clock, open);
    begun
        .map(Rc::new)
        .inspect_err(|error| complain(&format!("warning: {process}: not recorded: {error}")))
        .ok()
}

/// The first byte of a frame, which says what it is about.
const CHANNEL: u8 = b'C';
const MESSAGE: u8 = b'M';
const END: u8 = b'E';

/// A process's end of the socket.
pub(super) struct Sender {
    socket: UnixDatagram,
    topics: Vec<String>,
    frame: Vec<u8>,
}

impl Sender {
    /// By a socket that is connected with the launcher's.
    pub const fn to(socket: UnixDatagram) -> Sender {
        Sender { socket, topics: Vec::new(), frame: Vec::new() }
    }

    /// Sends a frame of texts; each of them but the last one stands after its length.
    fn send(&mut self, kind: u8, number: u64, texts: &[&str]) -> io::Result<()> {
        self.frame.clear();
        self.frame.push(kind);
        self.frame.extend(number.to_le_bytes());
        for (i, text) in texts.iter().enumerate() {
            if i + 1 < texts.len() {
                let len = u16::try_from(text.len()).map_err(io::Error::other)?;
                self.frame.extend(len.to_le_bytes());
            }
            self.frame.extend(text.as_bytes());
        }
        self.socket.send(&self.frame).map(drop)
    }
}

impl Outlet for Sender {
    fn open(&mut self, topic: &str, schema: &str, text: &str) -> io::Result<u16> {
        self.send(CHANNEL, 0, &[topic, schema, text])?;
        self.topics.push(topic.to_owned());
        u16::try_from(self.topics.len() - 1).map_err(io::Error::other)
    }

    fn write(&mut self, channel: u16, time: Nanos, json: &str) -> io::Result<()> {
        let topic = core::mem::take(&mut self.topics[usize::from(channel)]);
        let sent = self.send(MESSAGE, time, &[&topic, json]);
        self.topics[usize::from(channel)] = topic;
        sent
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }

    fn finish(&mut self, dropped: u64) -> io::Result<()> {
        self.send(END, dropped, &[])
    }
}

/// A frame as it was received.
struct Frame<'a> {
    kind: u8,
    number: u64,
    rest: &'a [u8],
}

impl<'a> Frame<'a> {
    fn read(bytes: &'a [u8]) -> Option<Frame<'a>> {
        let (&kind, bytes) = bytes.split_first()?;
        let (number, rest) = bytes.split_first_chunk::<8>()?;
        Some(Frame { kind, number: u64::from_le_bytes(*number), rest })
    }

    fn text(&mut self) -> Option<&'a str> {
        let (len, rest) = self.rest.split_first_chunk::<2>()?;
        let (text, rest) = rest.split_at_checked(usize::from(u16::from_le_bytes(*len)))?;
        self.rest = rest;
        core::str::from_utf8(text).ok()
    }

    fn last(&self) -> Option<&'a str> {
        core::str::from_utf8(self.rest).ok()
    }
}

/// The launcher's end of the socket.
pub(crate) struct Relay {
    closing: Arc<AtomicBool>,
    received: Arc<AtomicU64>,
    thread: Option<JoinHandle<()>>,
    file: PathBuf,
}

impl Relay {
    /// Begins to receive the messages of a session's processes.
    ///
    /// # Errors
    /// [`NotRecorded`]: the file cannot be written, or the socket cannot be made.
    pub fn listen(
        folder: &Path,
        recording: &Recording,
        layout: &Layout,
        clock: Clock,
    ) -> Result<Relay, NotRecorded> {
        let file = recording.file().to_owned();
        let unwritable =
            |error: io::Error| NotRecorded::Unwritable { file: file.clone(), error: error.to_string() };
        can_be_written(&file).map_err(unwritable)?;
        let socket = UnixDatagram::bind(socket(folder, clock)).map_err(unwritable)?;
        socket.set_read_timeout(Some(REST)).map_err(unwritable)?;
        let (closing, received) = (Arc::new(AtomicBool::new(false)), Arc::new(AtomicU64::new(0)));
        let receiver = Receiver {
            socket,
            closing: Arc::clone(&closing),
            received: Arc::clone(&received),
            channels: Vec::new(),
            written: 0,
            dropped: 0,
            name: file.display().to_string(),
        };
        let (path, layout) = (file.clone(), recording.of(layout.clone()));
        let link = if clock == Clock::Real { REAL_TIME } else { "processes under the virtual clock" };
        let run = move || receiver.run(&path, &layout, link);
        let thread =
            std::thread::Builder::new().name("recorder".to_owned()).spawn(run).map_err(unwritable)?;
        Ok(Relay { closing, received, thread: Some(thread), file })
    }
}

impl Drop for Relay {
    /// Waits until all that the processes have sent before they ended is written, as long as the file takes data.
    fn drop(&mut self) {
        let Some(thread) = self.thread.take() else { return };
        self.closing.store(true, Ordering::Release);
        let timeout = write_timeout(&self.file);
        let (mut since, mut seen) = (Instant::now(), self.received.load(Ordering::Acquire));
        while !thread.is_finished() {
            let received = self.received.load(Ordering::Acquire);
            if received != seen {
                (since, seen) = (Instant::now(), received);
            } else if since.elapsed() > timeout {
                complain(&format!(
                    "warning: {}: nothing more can be written: records are lost",
                    self.file.display()
                ));
                return;
            }
            std::thread::sleep(Duration::from_millis(1));
        }
    }
}

/// The state of the launcher's thread.
struct Receiver {
    socket: UnixDatagram,
    closing: Arc<AtomicBool>,
    received: Arc<AtomicU64>,
    channels: Vec<(String, u16)>,
    written: u64,
    dropped: u64,
    name: String,
}

impl Receiver {
    fn run(mut self, path: &Path, layout: &Layout, link: &str) {
        let file = McapFile::create(path, layout, link);
        let mut file = file.map_err(|error| self.warn(&error)).ok();
        let mut buffer = vec![0; LONGEST];
        let mut flushed = Instant::now();
        loop {
            match self.socket.recv(&mut buffer) {
                Ok(len) => {
                    self.received.fetch_add(1, Ordering::AcqRel);
                    self.take(&buffer[..len], &mut file);
                }
                Err(error) if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) => {
                    // All processes have ended before the launcher closes the recording.
                    if self.closing.load(Ordering::Acquire) {
                        break;
                    }
                }
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(error) => {
                    self.warn(&error);
                    break;
                }
            }
            if flushed.elapsed() > Duration::from_secs(1) {
                flushed = Instant::now();
                self.attempt(&mut file, Outlet::flush);
            }
        }
        let (written, dropped) = (self.written, self.dropped);
        self.attempt(&mut file, |file| file.finish(dropped));
        if dropped > 0 {
            complain(&format!("warning: {}: {dropped} of {} records are lost", self.name, written + dropped));
        }
    }

    fn take(&mut self, bytes: &[u8], file: &mut Option<McapFile>) {
        let Some(mut frame) = Frame::read(bytes) else { return };
        match frame.kind {
            END => self.dropped += frame.number,
            CHANNEL => {
                let (Some(topic), Some(schema), Some(text)) = (frame.text(), frame.text(), frame.last())
                else {
                    return;
                };
                self.attempt(file, |file| file.open(topic, schema, text)).into_iter().for_each(|channel| {
                    self.channels.push((topic.to_owned(), channel));
                });
            }
            MESSAGE => {
                let (Some(topic), Some(json)) = (frame.text(), frame.last()) else { return };
                let channel =
                    self.channels.iter().find(|(known, _)| known == topic).map(|(_, channel)| *channel);
                let time = frame.number;
                let written =
                    channel.and_then(|channel| self.attempt(file, |file| file.write(channel, time, json)));
                match written {
                    Some(()) => self.written += 1,
                    None => self.dropped += 1,
                }
            }
            _ => {}
        }
    }

    fn attempt<T>(
        &self,
        file: &mut Option<McapFile>,
        work: impl FnOnce(&mut McapFile) -> io::Result<T>,
    ) -> Option<T> {
        match work(file.as_mut()?) {
            Ok(done) => Some(done),
            Err(error) => {
                self.warn(&error);
                *file = None;
                None
            }
        }
    }

    /// Warns once; after the warning nothing more is written.
    fn warn(&self, error: &io::Error) {
        complain(&format!("warning: {}: cannot be written: {error}; the run goes on unrecorded", self.name));
    }
}
