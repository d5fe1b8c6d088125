//! The ends of ports and boards that are in this process.
//!
//! In: messages. Out: envelopes in shared memory, and a wake-up of the process that reads them. An end is made before
//! its service is: the cell is put together first and connected afterwards, so an end that belongs to another process
//! stays empty and does nothing.

use core::cell::{Cell, OnceCell, RefCell};
use std::rc::Rc;

use iceoryx2::active_request::ActiveRequest;
use iceoryx2::pending_response::PendingResponse;
use iceoryx2::port::client::Client as IpcClient;
use iceoryx2::port::reader::EntryHandle;
use iceoryx2::port::server::Server as IpcServer;
use iceoryx2::port::writer::EntryHandleMut;
use iceoryx2::prelude::ipc;

use super::bell::Bell;
use crate::link::envelope::{Envelope, Seal};
use crate::link::{Board, Client, Server};
use crate::message::Message;

pub(super) type RequestPort = IpcClient<ipc::Service, Envelope, (), Envelope, ()>;
pub(super) type ReplyPort = IpcServer<ipc::Service, Envelope, (), Envelope, ()>;
type Pending = PendingResponse<ipc::Service, Envelope, (), Envelope, ()>;
type Active = ActiveRequest<ipc::Service, Envelope, (), Envelope, ()>;

/// Wakes the process at the other end.
pub(super) enum Rope {
    /// By its bell.
    Bell(Bell),
    /// In lock-step: the launcher resumes it. Which place, and the places to be resumed.
    Mark(usize, Rc<Cell<u64>>),
}

impl Rope {
    fn pull(&self) {
        match self {
            // A peer that is gone is not woken; that it is gone is told by its silence and by the launcher.
            Rope::Bell(bell) => bell.ring(),
            Rope::Mark(place, woken) => woken.set(woken.get() | 1 << place),
        }
    }
}

/// The asking end of a port.
pub(super) struct Asking {
    pub client: RequestPort,
    pub rope: Rope,
    pub seal: Seal,
    pending: RefCell<Option<Pending>>,
    sequence: Cell<u64>,
}

impl Asking {
    pub fn new(client: RequestPort, rope: Rope, seal: Seal) -> Self {
        Asking { client, rope, seal, pending: RefCell::new(None), sequence: Cell::new(0) }
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
        // It is connected once: its fabric connects all ends of its list in one pass.
        drop(self.0.set(with));
    }
}

impl Client for End<Asking> {
    fn send(&self, request: &Message) {
        let Some(end) = self.0.get() else { return };
        let sequence = end.sequence.get() + 1;
        end.sequence.set(sequence);
        let mut pending = end.pending.borrow_mut();
        // The one before is given up, so that its answer cannot be taken for the answer to this one.
        *pending = None;
        let envelope = Envelope::seal(request, end.seal, sequence);
        // A request that cannot be sent is a lost one: there is no answer in time.
        let Ok(loan) = end.client.loan_uninit() else { return };
        *pending = loan.write_payload(envelope).send().ok();
        end.rope.pull();
    }

    fn receive(&self, reply: &mut Message) -> bool {
        let Some(end) = self.0.get() else { return false };
        let mut pending = end.pending.borrow_mut();
        let Some(waiting) = &*pending else { return false };
        while let Ok(Some(response)) = waiting.receive() {
            let envelope = response.payload();
            let is_ours = envelope.is_under(end.seal) && envelope.sequence == end.sequence.get();
            if is_ours && envelope.open(reply).is_ok() {
                drop(response);
                *pending = None;
                return true;
            }
        }
        false
    }
}

/// The answering end of a port.
pub(super) struct Answering {
    pub server: ReplyPort,
    pub seal: Seal,
    /// Known once the other side has made its bell.
    pub rope: OnceCell<Rope>,
    active: RefCell<Option<Active>>,
    /// The request taken last: one that was taken, or overtaken, is none.
    taken: Cell<u64>,
}

impl Answering {
    pub fn new(server: ReplyPort, seal: Seal) -> Self {
        Answering { server, seal, rope: OnceCell::new(), active: RefCell::new(None), taken: Cell::new(0) }
    }
}

impl Server for End<Answering> {
    fn receive(&self, request: &mut Message) -> bool {
        let Some(end) = self.0.get() else { return false };
        let mut newest = None;
        while let Ok(Some(active)) = end.server.receive() {
            let envelope = active.payload();
            let is_new = envelope.is_under(end.seal) && envelope.sequence > end.taken.get();
            if is_new && envelope.open(request).is_ok() {
                end.taken.set(envelope.sequence);
                newest = Some(active);
            }
        }
        let came = newest.is_some();
        if came {
            *end.active.borrow_mut() = newest;
        }
        came
    }

    fn reply(&self, reply: &Message) {
        let Some(end) = self.0.get() else { return };
        let active = end.active.borrow();
        let Some(active) = &*active else { return };
        let envelope = Envelope::seal(reply, end.seal, active.payload().sequence);
        // An answer that cannot be sent is a lost one: whoever waits for it has a deadline.
        let Ok(loan) = active.loan_uninit() else { return };
        if loan.write_payload(envelope).send().is_ok()
            && let Some(rope) = end.rope.get()
        {
            rope.pull();
        }
    }
}

/// The end of a board in the process that writes it or reads it.
pub(super) enum BoardEnd {
    Writes(EntryHandleMut<ipc::Service, u64, Envelope>, Seal, Cell<u64>),
    Reads(EntryHandle<ipc::Service, u64, Envelope>, Seal),
}

impl Board for End<BoardEnd> {
    fn write(&self, message: &Message) {
        if let Some(BoardEnd::Writes(entry, seal, shown)) = self.0.get() {
            shown.set(shown.get() + 1);
            entry.update_with_copy(Envelope::seal(message, *seal, shown.get()));
        }
    }

    fn read(&self, message: &mut Message) -> bool {
        match self.0.get() {
            Some(BoardEnd::Reads(entry, seal)) => {
                let shown = entry.get();
                shown.is_under(*seal) && shown.open(message).is_ok()
            }
            Some(BoardEnd::Writes(..)) | None => false,
        }
    }
}
