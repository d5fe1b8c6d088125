//! The memory link: every process is a stackful coroutine on one thread, under a virtual clock.
//!
//! The clock stands while any process can run and then jumps to the earliest deadline, so a run is as fast as
//! the processor goes and the same to the bit every time: processes run in the order of their places.

use crate::link::Host;
use core::cell::{Cell, RefCell};
use std::rc::Rc;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};

use corosensei::stack::DefaultStack;
use corosensei::{Coroutine, CoroutineResult, Yielder};

use super::overflow::{self, Guard};
use super::places::{MAX_PROCESSES, Places};
use super::{Board, Body, Client, Closed, Link, Nanos, Server, Waiter};
use crate::link::message::Message;
use crate::model::fault::ProcessId;

/// Stack of a process \[bytes\]; pages are used only when touched, and a guard page ends the stack ([`overflow`]).
const STACK: usize = 1 << 20;

const NEVER: Nanos = Nanos::MAX;

/// How often a process that ignores the closing of the cell is resumed before its stack is given up.
const CLOSING_RESUMES: u32 = 10_000;

/// The state that scheduler, waiters and ports share.
struct Shared {
    now: Cell<Nanos>,
    /// The processes that have something to do.
    ready: Cell<Places>,
    deadlines: RefCell<Vec<Nanos>>,
    closing: Cell<bool>,
}

impl Shared {
    fn wake(&self, process: usize) {
        self.ready.set(self.ready.get().with(process));
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

type Process = Coroutine<(), (), (), DefaultStack>;

/// All processes of a cell.
pub struct Scheduler {
    shared: Rc<Shared>,
    processes: Vec<(String, Option<(Process, Guard)>)>,
    pulse: Option<Arc<Pulse>>,
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
        Scheduler {
            shared: Rc::new(Shared {
                now: Cell::new(0),
                ready: Cell::new(Places::NONE),
                deadlines: RefCell::new(Vec::new()),
                closing: Cell::new(false),
            }),
            processes: Vec::new(),
            pulse: None,
        }
    }

    /// Shows which process runs.
    pub fn show(&mut self, pulse: Arc<Pulse>) {
        self.pulse = Some(pulse);
    }

    /// The processes' names, by their places.
    pub fn names(&self) -> Vec<String> {
        self.processes.iter().map(|(name, _)| name.clone()).collect()
    }

    /// Wakes the processes at places, for messages that did not go through this link.
    pub fn waker(&self) -> Box<dyn Fn(Places)> {
        let shared = Rc::clone(&self.shared);
        Box::new(move |places| shared.ready.set(shared.ready.get().and(places)))
    }

    /// Runs all processes to their end.
    ///
    /// # Errors
    /// [`Stuck`] when none can run and none waits for a time.
    pub fn run(mut self) -> Result<Nanos, Stuck> {
        overflow::listen();
        let outcome = self.run_until_closing();
        self.shared.closing.set(true);
        // Every wait now returns at once: bodies run to their end, whatever they were waiting for.
        for _ in 0..CLOSING_RESUMES {
            let mut alive = false;
            for place in 0..self.processes.len() {
                alive |= self.resume(place);
            }
            if !alive {
                break;
            }
        }
        // What still runs ignores the closing. Its stack is given up: unwinding it could be caught again.
        for (_, process) in &mut self.processes {
            core::mem::forget(process.take());
        }
        outcome.map(|()| self.shared.now.get())
    }

    fn run_until_closing(&mut self) -> Result<(), Stuck> {
        while !self.shared.closing.get() {
            let ready = self.shared.ready.get();
            let Some(place) = ready.first() else {
                self.advance()?;
                continue;
            };
            self.shared.ready.set(ready.without(place));
            self.resume(place);
        }
        Ok(())
    }

    /// Resumes a process; whether it is still alive.
    fn resume(&mut self, place: usize) -> bool {
        let Some((process, guard)) = &mut self.processes[place].1 else { return false };
        if let Some(pulse) = &self.pulse {
            pulse.place.store(place, Ordering::Relaxed);
            pulse.resumed.fetch_add(1, Ordering::Relaxed);
        }
        match guard.during(|| process.resume(())) {
            CoroutineResult::Yield(()) => true,
            CoroutineResult::Return(()) => {
                self.processes[place].1 = None;
                self.shared.deadlines.borrow_mut()[place] = NEVER;
                false
            }
        }
    }

    /// Moves the clock to the earliest deadline.
    fn advance(&self) -> Result<(), Stuck> {
        let deadlines = self.shared.deadlines.borrow();
        let next = deadlines.iter().copied().min().unwrap_or(NEVER);
        if next == NEVER {
            let alive = self.processes.iter().filter(|(_, process)| process.is_some());
            let names: Vec<_> = alive.map(|(name, _)| name.as_str()).collect();
            return Err(Stuck::Deadlock(names.join(", ")));
        }
        self.shared.now.set(next);
        for (place, &deadline) in deadlines.iter().enumerate() {
            if deadline <= next {
                self.shared.wake(place);
            }
        }
        Ok(())
    }
}

impl Link for Scheduler {
    fn place(&mut self, process: ProcessId) -> usize {
        assert!(self.processes.len() < MAX_PROCESSES, "a cell has at most {MAX_PROCESSES} processes");
        self.shared.deadlines.borrow_mut().push(NEVER);
        self.processes.push((process.to_string(), None));
        self.processes.len() - 1
    }

    fn port(&mut self, client: usize, server: usize) -> (Box<dyn Client>, Box<dyn Server>) {
        let port = Rc::new(Port {
            request: Slot::new(server),
            reply: Slot::new(client),
            shared: Rc::clone(&self.shared),
        });
        (Box::new(MemoryClient(Rc::clone(&port))), Box::new(MemoryServer(port)))
    }

    fn board(&mut self, _: usize, _: usize) -> Rc<dyn Board> {
        Rc::new(MemoryBoard::default())
    }

    fn body(&mut self, place: usize, body: Body) -> Result<(), Stuck> {
        let name = &self.processes[place].0;
        let stack =
            DefaultStack::new(STACK).map_err(|error| Stuck::Stack(name.clone(), error.to_string()))?;
        let guard = Guard::of(name, &stack, STACK);
        let shared = Rc::clone(&self.shared);
        let process = Coroutine::with_stack(stack, move |yielder: &Yielder<(), ()>, ()| {
            body(Host::of(&MemoryWaiter { shared, place, yielder }));
        });
        self.processes[place].1 = Some((process, guard));
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

impl Waiter for MemoryWaiter<'_> {
    fn now(&self) -> Nanos {
        self.shared.now.get()
    }

    fn wait(&self, deadline: Option<Nanos>) -> Result<(), Closed> {
        let deadline = deadline.unwrap_or(NEVER);
        if deadline > self.now() && !self.shared.closing.get() {
            self.shared.deadlines.borrow_mut()[self.place] = deadline;
            self.yielder.suspend(());
            self.shared.deadlines.borrow_mut()[self.place] = NEVER;
        }
        if self.shared.closing.get() { Err(Closed) } else { Ok(()) }
    }
}

/// One direction of a port.
struct Slot {
    message: RefCell<Message>,
    full: Cell<bool>,
    reader: usize,
}

impl Slot {
    fn new(reader: usize) -> Slot {
        Slot { message: RefCell::new(Message::empty()), full: Cell::new(false), reader }
    }

    fn put(&self, message: &Message, shared: &Shared) {
        self.message.borrow_mut().copy_from(message);
        self.full.set(true);
        shared.wake(self.reader);
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
    request: Slot,
    reply: Slot,
    shared: Rc<Shared>,
}

struct MemoryClient(Rc<Port>);
struct MemoryServer(Rc<Port>);

impl Client for MemoryClient {
    fn send(&self, request: &Message) {
        self.0.reply.full.set(false);
        self.0.request.put(request, &self.0.shared);
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
        self.0.reply.put(reply, &self.0.shared);
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
