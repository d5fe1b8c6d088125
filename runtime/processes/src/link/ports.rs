//! The ends of ports and boards that are in this process.
//!
//! In: messages. Out: envelopes in shared memory, and a wake-up of the process that reads them. The ends are made when
//! the cell is put together, and their services when it is connected; so an end that belongs to another process stays
//! empty and does nothing.
//!
//! A port is two boards: one shows the newest request, the other its answer, which carries the request's ordinal
//! ([`numbering`](mrroc_core::link::numbering)). Blackboards are used because iceoryx2's request-response allocates
//! three times for an exchange (for the request on both sides, and for the answer), and a blackboard does not allocate.

use core::cell::{Cell, OnceCell};
use std::rc::Rc;

use iceoryx2::port::reader::EntryHandle;
use iceoryx2::port::writer::EntryHandleMut;
use iceoryx2::prelude::{ZeroCopySend, ipc};

use super::wake_futex::WakeFutex;
use mrroc_core::link::envelope::{Envelope, Seal};
use mrroc_core::link::message::Message;
use mrroc_core::link::numbering::{self, Disposition};
use mrroc_core::link::places::Places;
use mrroc_core::link::{Board, Client, Server};

/// An envelope as it lies in shared memory.
#[derive(Clone, Copy, Debug)]
#[repr(transparent)]
pub(super) struct Packet(pub Envelope);

#[expect(unsafe_code, reason = "it says to iceoryx2 that the type may be in shared memory")]
// SAFETY: an envelope consists of words, in C's layout: it has no pointer and nothing to drop, and every bit pattern is
// valid.
unsafe impl ZeroCopySend for Packet {
    unsafe fn type_name() -> &'static str {
        "mrroc::Envelope"
    }
}

/// The end of a board in shared memory that is written.
pub(super) type Writes = EntryHandleMut<ipc::Service, u64, Packet>;
/// The end of a board in shared memory that is read.
pub(super) type Reads = EntryHandle<ipc::Service, u64, Packet>;

/// Wakes the process at the other end.
pub(super) enum Waker {
    /// By its futex.
    WakeFutex(WakeFutex),
    /// In lock-step the launcher resumes it: the place of the process, and the set of places to be resumed.
    Mark(usize, Rc<Cell<Places>>),
}

impl Waker {
    fn wake(&self) {
        match self {
            // Waking has no effect on a peer that is gone; its silence and the launcher tell that it is gone.
            Waker::WakeFutex(wake_futex) => wake_futex.wake(),
            Waker::Mark(place, woken) => woken.set(woken.get().with(*place)),
        }
    }
}

/// One end of a port: the board that it writes, and what it gets once the other side has made its own board.
pub(super) struct PortEnd {
    writes: Writes,
    other: OnceCell<(Reads, Waker)>,
}

impl PortEnd {
    const fn new(writes: Writes) -> Self {
        PortEnd { writes, other: OnceCell::new() }
    }

    /// Connects this end with the other side.
    pub fn meet(&self, reads: Reads, waker: Waker) {
        // The round connects each port once, so the cell is still empty.
        drop(self.other.set((reads, waker)));
    }

    /// Writes an envelope to the board and wakes its reader.
    fn show(&self, envelope: Envelope) {
        self.writes.update_with_copy(Packet(envelope));
        if let Some((_, waker)) = self.other.get() {
            waker.wake();
        }
    }

    /// Reads what the other side shows; `None` until that side has made its own board.
    fn look<T>(&self, looks: impl FnOnce(&Envelope) -> T) -> Option<T> {
        self.other.get().map(|(reads, _)| looks(&reads.get().0))
    }
}

/// The asking end of a port.
pub(super) struct Asking {
    pub end: PortEnd,
    numbers: numbering::Asking,
}

impl Asking {
    pub const fn new(writes: Writes, seal: Seal) -> Asking {
        Asking { end: PortEnd::new(writes), numbers: numbering::Asking::new(seal) }
    }
}

/// The answering end of a port.
pub(super) struct Answering {
    pub end: PortEnd,
    numbers: numbering::Answering,
}

impl Answering {
    pub const fn new(writes: Writes, seal: Seal) -> Answering {
        Answering { end: PortEnd::new(writes), numbers: numbering::Answering::new(seal) }
    }
}

/// An end of a port that is connected later, or never, because it belongs to another process.
pub(super) struct End<T>(pub Rc<OnceCell<T>>);

impl<T> Clone for End<T> {
    fn clone(&self) -> Self {
        End(Rc::clone(&self.0))
    }
}

impl<T> End<T> {
    pub fn new() -> End<T> {
        End(Rc::new(OnceCell::new()))
    }

    pub fn connect(&self, with: T) {
        // The fabric connects each end of its list once, so the cell is still empty.
        drop(self.0.set(with));
    }
}

impl Client for End<Asking> {
    fn send(&self, request: &Message) {
        if let Some(Asking { end, numbers }) = self.0.get() {
            end.show(numbers.ask(request));
        }
    }

    fn send_again(&self) {
        if let Some(Asking { end, numbers }) = self.0.get()
            && let Some(envelope) = numbers.ask_again()
        {
            end.show(envelope);
        }
    }

    fn receive(&self, reply: &mut Message) -> bool {
        let Some(Asking { end, numbers }) = self.0.get() else { return false };
        end.look(|shown| numbers.hears(shown, reply)).unwrap_or(false)
    }
}

impl Server for End<Answering> {
    fn receive(&self, request: &mut Message) -> bool {
        let Some(Answering { end, numbers }) = self.0.get() else { return false };
        match end.look(|shown| numbers.hears(shown, request)) {
            Some(Disposition::New) => true,
            Some(Disposition::Again(answer)) => {
                end.show(answer);
                false
            }
            Some(Disposition::Nothing) | None => false,
        }
    }

    fn reply(&self, reply: &Message) {
        if let Some(Answering { end, numbers }) = self.0.get() {
            end.show(numbers.answer(reply));
        }
    }
}

/// The end of a board in the process that writes it or reads it.
pub(super) enum BoardEnd {
    Writes(Writes, Seal, Cell<u64>),
    Reads(Reads, Seal),
}

impl Board for End<BoardEnd> {
    fn write(&self, message: &Message) {
        if let Some(BoardEnd::Writes(entry, seal, shown)) = self.0.get() {
            shown.set(shown.get() + 1);
            entry.update_with_copy(Packet(Envelope::seal(message, *seal, shown.get())));
        }
    }

    fn read(&self, message: &mut Message) -> bool {
        match self.0.get() {
            Some(BoardEnd::Reads(entry, seal)) => {
                let shown = entry.get();
                shown.0.is_under(*seal) && shown.0.open(message).is_ok()
            }
            Some(BoardEnd::Writes(..)) | None => false,
        }
    }
}
