//! The memory link: every process is a stackful coroutine on one thread, under a virtual clock.
//!
//! The clock stands while any process can run and then jumps to the earliest deadline, so a run is as fast as
//! the processor goes and the same to the bit every time: processes run in the order of their places.
//!
//! A process that waits for a reply runs the others itself, in that same order, until it is its turn again: mostly the one
//! that it asks, and then it goes on without a switch back to the scheduler.

use crate::link::Host;
use core::any::Any;
use core::cell::{Cell, OnceCell, RefCell};
use std::rc::Rc;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};

use corosensei::stack::DefaultStack;
use corosensei::{Coroutine, CoroutineResult, Yielder};

use super::overflow::{self, Guard};
use super::places::{MAX_PROCESSES, PlaceCells, Places};
use super::{Board, Body, Client, Closed, Link, Nanos, Server, Waiter};
use crate::link::message::Message;
use crate::model::fault::ProcessId;

/// Stack of a process \[bytes\]; pages are used only when touched, and a guard page ends the stack ([`overflow`]).
const STACK: usize = 1 << 20;

const NEVER: Nanos = Nanos::MAX;

/// How often a process that ignores the closing of the cell is resumed before its stack is given up.
const CLOSING_RESUMES: u32 = 10_000;

type Process = Coroutine<(), (), (), DefaultStack>;

/// A process, and what it waits for.
struct Seat {
    /// Its coroutine, unless it runs, is over or has none yet.
    asleep: Cell<Option<Box<(Process, Guard)>>>,
    /// Whether it runs, or waits on a stack below the one that runs.
    runs: Cell<bool>,
    deadline: Cell<Nanos>,
    /// The port whose reply alone wakes it; [`ANY`]: every message does.
    reply: Cell<usize>,
}

impl Seat {
    fn empty() -> Seat {
        Seat {
            asleep: Cell::new(None),
            runs: Cell::new(false),
            deadline: Cell::new(NEVER),
            reply: Cell::new(ANY),
        }
    }

    /// Whether a process is here that is not over; none of them runs.
    fn is_taken(&self) -> bool {
        let asleep = self.asleep.take();
        let is_taken = asleep.is_some();
        self.asleep.set(asleep);
        is_taken
    }
}

/// Every message wakes the process.
const ANY: usize = usize::MAX;

/// The state that scheduler, waiters and ports share.
struct Shared {
    now: Cell<Nanos>,
    /// The processes that have something to do.
    ready: PlaceCells,
    /// The processes, by their places.
    seats: Box<[Seat]>,
    closing: Cell<bool>,
    pulse: OnceCell<Arc<Pulse>>,
    /// The first panic that no process has caught.
    panic: Cell<Option<Box<dyn Any + Send>>>,
}

impl Shared {
    fn new() -> Shared {
        Shared {
            now: Cell::new(0),
            ready: PlaceCells::default(),
            seats: (0..MAX_PROCESSES).map(|_| Seat::empty()).collect(),
            closing: Cell::new(false),
            pulse: OnceCell::new(),
            panic: Cell::new(None),
        }
    }

    /// A request has come for a process.
    fn wake(&self, process: usize) {
        self.ready.insert(process);
    }

    /// The reply of a port has come for a process.
    fn wake_by_reply(&self, process: usize, port: usize) {
        let reply = self.seats[process].reply.get();
        if reply == ANY || reply == port {
            self.ready.insert(process);
        }
    }

    /// Runs a process until it waits, on the stack of whoever calls this; whether it is still alive.
    fn resume(&self, place: usize) -> bool {
        let seat = &self.seats[place];
        let Some(mut process) = seat.asleep.take() else { return false };
        seat.runs.set(true);
        self.show(place);
        let (coroutine, guard) = &mut *process;
        let below = guard.enter();
        let result = coroutine.resume(());
        drop(below);
        seat.runs.set(false);
        let is_alive = matches!(result, CoroutineResult::Yield(()));
        if is_alive {
            seat.asleep.set(Some(process));
        } else {
            seat.deadline.set(NEVER);
        }
        is_alive
    }

    /// Shows the watchdog that the process at a place runs from now on.
    fn show(&self, place: usize) {
        if let Some(pulse) = self.pulse.get() {
            pulse.place.store(place, Ordering::Relaxed);
            pulse.resumed.fetch_add(1, Ordering::Relaxed);
        }
    }

    /// Runs the processes that are ready, as the scheduler would, until it is the turn of the one at `place`, which calls
    /// this. Whether that has come: not where none is ready, or where it is the turn of one on a stack below.
    fn run_others(&self, place: usize) -> bool {
        while !self.closing.get() {
            let Some(first) = self.ready.first() else { return false };
            if first == place {
                self.ready.remove(place);
                self.show(place);
                return true;
            }
            if self.seats[first].runs.get() {
                return false;
            }
            self.ready.remove(first);
            self.resume(first);
        }
        false
    }
}

/// Shows a watchdog which process runs, and whether it still does.
#[derive(Debug, Default)]
pub struct Pulse {
    /// How often a process has been resumed.
    pub resumed: AtomicU64,
    /// The place of the one that was resumed last.
    pub place: AtomicUsize,
}

/// All processes of a cell.
pub struct Scheduler {
    shared: Rc<Shared>,
    /// How many ports there are.
    ports: usize,
    /// The processes' names, by their places.
    names: Vec<String>,
}

/// The cell could not run on.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Stuck {
    /// No process can run and none waits for a time.
    #[error("deadlock: {0} wait for messages that nobody will send")]
    Deadlock(String),
    /// No stack could be had for a process.
    #[error("no stack for process {0}: {1}")]
    Stack(String, String),
}

impl Default for Scheduler {
    fn default() -> Self {
        Scheduler::new()
    }
}

impl Scheduler {
    /// No process, at time 0.
    pub fn new() -> Scheduler {
        Scheduler { shared: Rc::new(Shared::new()), ports: 0, names: Vec::new() }
    }

    /// Shows which process runs.
    pub fn show(&mut self, pulse: Arc<Pulse>) {
        // The first one is shown them.
        let _ = self.shared.pulse.set(pulse);
    }

    /// The processes' names, by their places.
    pub fn names(&self) -> Vec<String> {
        self.names.clone()
    }

    /// Wakes the processes at places, for messages that did not go through this link.
    pub fn waker(&self) -> Box<dyn Fn(Places)> {
        let shared = Rc::clone(&self.shared);
        Box::new(move |places| shared.ready.insert_all(places))
    }

    /// Runs all processes to their end.
    ///
    /// # Errors
    /// [`Stuck`] when none can run and none waits for a time.
    pub fn run(self) -> Result<Nanos, Stuck> {
        overflow::listen();
        let shared = &*self.shared;
        let outcome = self.run_until_closing();
        shared.closing.set(true);
        // Every wait now returns at once: bodies run to their end, whatever they were waiting for.
        for _ in 0..CLOSING_RESUMES {
            let mut alive = false;
            for place in 0..self.names.len() {
                alive |= shared.resume(place);
            }
            if !alive {
                break;
            }
        }
        // What still runs ignores the closing. Its stack is given up: unwinding it could be caught again.
        for seat in &shared.seats {
            core::mem::forget(seat.asleep.take());
        }
        if let Some(panic) = shared.panic.take() {
            std::panic::resume_unwind(panic);
        }
        outcome.map(|()| shared.now.get())
    }

    fn run_until_closing(&self) -> Result<(), Stuck> {
        let shared = &*self.shared;
        while !shared.closing.get() {
            match shared.ready.first() {
                Some(place) => {
                    shared.ready.remove(place);
                    shared.resume(place);
                }
                None => self.advance()?,
            }
        }
        Ok(())
    }

    /// Moves the clock to the earliest deadline.
    fn advance(&self) -> Result<(), Stuck> {
        let seats = &self.shared.seats[..self.names.len()];
        // In one pass: whoever waits for the earliest deadline so far.
        let (mut next, mut due) = (NEVER, Places::NONE);
        for (place, seat) in seats.iter().enumerate() {
            let deadline = seat.deadline.get();
            if deadline < next {
                (next, due) = (deadline, Places::of(place));
            } else if deadline == next && next != NEVER {
                due = due.with(place);
            }
        }
        if next == NEVER {
            let alive = self.names.iter().zip(seats).filter(|(_, seat)| seat.is_taken());
            let names: Vec<_> = alive.map(|(name, _)| name.as_str()).collect();
            return Err(Stuck::Deadlock(names.join(", ")));
        }
        self.shared.now.set(next);
        self.shared.ready.insert_all(due);
        Ok(())
    }
}

impl Drop for Scheduler {
    /// The processes keep what they share, and it keeps them.
    fn drop(&mut self) {
        for seat in &self.shared.seats {
            drop(seat.asleep.take());
        }
    }
}

impl Link for Scheduler {
    fn place(&mut self, process: ProcessId) -> usize {
        assert!(self.names.len() < MAX_PROCESSES, "a cell has at most {MAX_PROCESSES} processes");
        self.names.push(process.to_string());
        self.names.len() - 1
    }

    fn port(&mut self, client: usize, server: usize) -> (Box<dyn Client>, Box<dyn Server>) {
        self.ports += 1;
        let port = Rc::new(Port {
            number: self.ports,
            request: Slot::empty(),
            server,
            reply: Slot::empty(),
            client,
            shared: Rc::clone(&self.shared),
        });
        (Box::new(MemoryClient(Rc::clone(&port))), Box::new(MemoryServer(port)))
    }

    fn board(&mut self, _: usize, _: usize) -> Rc<dyn Board> {
        Rc::new(MemoryBoard::default())
    }

    fn body(&mut self, place: usize, body: Body) -> Result<(), Stuck> {
        let name = &self.names[place];
        let stack =
            DefaultStack::new(STACK).map_err(|error| Stuck::Stack(name.clone(), error.to_string()))?;
        let guard = Guard::of(name, &stack, STACK);
        let shared = Rc::clone(&self.shared);
        let process = Coroutine::with_stack(stack, move |yielder: &Yielder<(), ()>, ()| {
            let waiter = MemoryWaiter { shared, place, yielder };
            let run = core::panic::AssertUnwindSafe(|| body(Host::of(&waiter)));
            if let Err(panic) = std::panic::catch_unwind(run) {
                // On another process's stack it would be that one's.
                let first = waiter.shared.panic.take().unwrap_or(panic);
                waiter.shared.panic.set(Some(first));
                waiter.shared.closing.set(true);
            }
        });
        self.shared.seats[place].asleep.set(Some(Box::new((process, guard))));
        self.shared.wake(place);
        Ok(())
    }

    fn closer(&self) -> Box<dyn Fn()> {
        let shared = Rc::clone(&self.shared);
        Box::new(move || shared.closing.set(true))
    }
}

struct MemoryWaiter<'y> {
    shared: Rc<Shared>,
    place: usize,
    yielder: &'y Yielder<(), ()>,
}

impl MemoryWaiter<'_> {
    /// Lets other processes run until a time, or until a message comes that wakes this one.
    fn suspend(&self, deadline: Option<Nanos>, reply: usize) -> Result<(), Closed> {
        let shared = &*self.shared;
        let deadline = deadline.unwrap_or(NEVER);
        if deadline > shared.now.get() && !shared.closing.get() {
            let seat = &shared.seats[self.place];
            seat.deadline.set(deadline);
            seat.reply.set(reply);
            if reply == ANY || !shared.run_others(self.place) {
                self.yielder.suspend(());
            }
            seat.deadline.set(NEVER);
            seat.reply.set(ANY);
        }
        if shared.closing.get() { Err(Closed) } else { Ok(()) }
    }
}

impl Waiter for MemoryWaiter<'_> {
    fn now(&self) -> Nanos {
        self.shared.now.get()
    }

    fn wait(&self, deadline: Option<Nanos>) -> Result<(), Closed> {
        self.suspend(deadline, ANY)
    }

    fn wait_for_reply(&self, client: &dyn Client, deadline: Option<Nanos>) -> Result<(), Closed> {
        self.suspend(deadline, client.port().unwrap_or(ANY))
    }

    fn stands_still(&self) -> bool {
        true
    }
}

/// One direction of a port.
struct Slot {
    message: RefCell<Message>,
    full: Cell<bool>,
}

impl Slot {
    fn empty() -> Slot {
        Slot { message: RefCell::new(Message::empty()), full: Cell::new(false) }
    }

    fn put(&self, message: &Message) {
        self.message.borrow_mut().copy_from(message);
        self.full.set(true);
    }

    fn take(&self, message: &mut Message) -> bool {
        let full = self.full.replace(false);
        if full {
            message.copy_from(&self.message.borrow());
        }
        full
    }
}

struct Port {
    number: usize,
    request: Slot,
    /// The place of the process that requests come for, and of the one that replies come for.
    server: usize,
    reply: Slot,
    client: usize,
    shared: Rc<Shared>,
}

struct MemoryClient(Rc<Port>);
struct MemoryServer(Rc<Port>);

impl Client for MemoryClient {
    fn send(&self, request: &Message) {
        let port = &*self.0;
        port.reply.full.set(false);
        port.request.put(request);
        port.shared.wake(port.server);
    }

    fn port(&self) -> Option<usize> {
        Some(self.0.number)
    }

    fn receive(&self, reply: &mut Message) -> bool {
        self.0.reply.take(reply)
    }
}

impl Server for MemoryServer {
    fn receive(&self, request: &mut Message) -> bool {
        self.0.request.take(request)
    }

    fn reply(&self, reply: &Message) {
        let port = &*self.0;
        port.reply.put(reply);
        port.shared.wake_by_reply(port.client, port.number);
    }
}

/// A board that is a cell.
#[derive(Default)]
pub struct MemoryBoard(pub RefCell<Option<Message>>);

impl Board for MemoryBoard {
    fn write(&self, message: &Message) {
        self.0.borrow_mut().get_or_insert(*message).copy_from(message);
    }

    fn read(&self, message: &mut Message) -> bool {
        match &*self.0.borrow() {
            Some(shown) => {
                message.copy_from(shown);
                true
            }
            None => false,
        }
    }
}

#[cfg(test)]
mod tests;
