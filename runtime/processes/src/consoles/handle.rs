//! The launcher's handle of the console server.
//!
//! In: the processes of the cell, which of them have ended, and their figures. Out: presses of buttons for the MP. The
//! console server itself is a thread, [`Service`].

use std::collections::BTreeSet;
use std::io::{self, Read};
use std::os::fd::{AsFd, BorrowedFd};
use std::os::unix::fs::PermissionsExt;
use std::os::unix::net::{UnixListener, UnixStream};
use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::Instant;

use super::mp_session::MpSession;
use super::protocol::SOCKET;
use super::service::{Seat, Service};
use crate::board::StateBoard;
use crate::board::figures::Figures;
use crate::control::Frame;
use crate::machine::identity::{self, CellId};
use mrroc_core::console::complain;
use mrroc_core::fault::ProcessId;
use mrroc_core::link::Nanos;
use mrroc_core::observe::recording::CommandRecord;

/// The console server of a running cell.
pub(crate) struct ConsoleServer {
    presses: Receiver<(ProcessId, Frame)>,
    wakes: UnixStream,
    seats: Arc<Mutex<Vec<Seat>>>,
    /// When the cell's time began, on the machine's clock \[ns\]; 0 before it is known.
    origin: Arc<AtomicU64>,
    /// The thread ends when this end of the socket is closed.
    open: Option<UnixStream>,
    thread: Option<JoinHandle<()>>,
}

impl ConsoleServer {
    /// Opens the console server of a cell in its session's folder and under the cell's own name, for the processes by their
    /// places, each with its process number. What consoles ask for goes to a `record`, if there is one.
    ///
    /// # Errors
    /// The socket cannot be made, or the thread cannot be started.
    pub fn open(
        (folder, cell): (&Path, CellId),
        board: StateBoard,
        process_set: impl Iterator<Item = (ProcessId, u32)>,
        record: Option<Box<dyn CommandRecord>>,
    ) -> io::Result<ConsoleServer> {
        let path = folder.join(SOCKET);
        let listener = UnixListener::bind(&path)?;
        std::fs::set_permissions(&path, PermissionsExt::from_mode(0o600))?;
        let mut listeners = vec![listener];
        match identity::listen(cell) {
            Ok(listener) => listeners.push(listener),
            Err(error) => {
                complain(&format!("note: operator: the cell is found in its session's folder only: {error}"));
            }
        }
        listeners.iter().try_for_each(|listener| listener.set_nonblocking(true))?;
        let seats: Vec<_> =
            process_set.map(|(id, pid)| Seat { id, pid, runs: true, figures: Figures::default() }).collect();
        let sessions = MpSession::of(seats.iter().map(|seat| seat.id));
        let seats = Arc::new(Mutex::new(seats));
        let (wakes, waker) = UnixStream::pair()?;
        wakes.set_nonblocking(true)?;
        waker.set_nonblocking(true)?;
        let (open, end) = UnixStream::pair()?;
        let (sender, presses) = channel();
        let origin = Arc::new(AtomicU64::new(0));
        let service = Service {
            listeners,
            end,
            board,
            seats: Arc::clone(&seats),
            presses: sender,
            waker,
            consoles: Vec::new(),
            sessions,
            ids: 0,
            strangers: BTreeSet::new(),
            record,
            origin: Arc::clone(&origin),
            round: Instant::now(),
        };
        let thread =
            std::thread::Builder::new().name("console_server".to_owned()).spawn(move || service.run())?;
        Ok(ConsoleServer { presses, wakes, seats, origin, open: Some(open), thread: Some(thread) })
    }

    /// The file descriptor that becomes readable when a press has come.
    pub fn descriptor(&self) -> BorrowedFd<'_> {
        self.wakes.as_fd()
    }

    /// Makes the descriptor unreadable until the next press has come.
    pub fn clear(&self) {
        drop((&self.wakes).read(&mut [0; 64]));
    }

    /// Takes the presses that have come, each with the MP that it is for.
    pub fn presses(&self) -> impl Iterator<Item = (ProcessId, Frame)> {
        self.presses.try_iter()
    }

    /// Notes when the cell's time begins, on the machine's clock \[ns\]: commands are recorded by that time.
    pub fn begins(&self, origin: Nanos) {
        self.origin.store(origin, Ordering::Release);
    }

    /// Notes that a process has ended.
    pub fn ended(&self, id: ProcessId) {
        self.at_seat(id, |seat| seat.runs = false);
    }

    /// Notes the newest figures of a process.
    pub fn measured(&self, id: ProcessId, figures: Figures) {
        self.at_seat(id, |seat| seat.figures = figures);
    }

    fn at_seat(&self, id: ProcessId, change: impl FnMut(&mut Seat)) {
        let mut seats = self.seats.lock().unwrap_or_else(PoisonError::into_inner);
        seats.iter_mut().filter(|seat| seat.id == id).for_each(change);
    }
}

impl Drop for ConsoleServer {
    fn drop(&mut self) {
        drop(self.open.take());
        if let Some(thread) = self.thread.take() {
            // A thread that panicked has printed its message already.
            drop(thread.join());
        }
    }
}
