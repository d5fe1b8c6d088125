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

use super::overflow::{self, Guard, Running};
use super::places::{MAX_PROCESSES, PlaceCells, Places};
use super::{Board, Body, Client, Closed, Link, Nanos, Server, Waiter};
use crate::link::message::Message;
use crate::model::fault::ProcessId;

/// Stack of a process \[bytes\]; pages are used only when touched, and a guard page ends the stack ([`overflow`]).
const STACK: usize = 1 << 20;

const NEVER: Nanos = Nanos::MAX;

/// How often a process that ignores the closing of the cell is resumed before its stack is given up.
const CLOSING_RESUMES: u32 = 10_000;

/// What a process waits for.
#[derive(Debug)]
struct Waits {
    deadline: Cell<Nanos>,
    /// The port whose reply alone wakes it; [`ANY`]: every message does.
    reply: Cell<usize>,
}

/// Every message wakes the process.
const ANY: usize = usize::MAX;

/// The state that scheduler, waiters and ports share.
struct Shared {
    now: Cell<Nanos>,
    /// The processes that have something to do.
    ready: PlaceCells,
    /// What each process waits for, by its place.
    waits: Box<[Waits]>,
    closing: Cell<bool>,
}

impl Shared {
    fn new() -> Shared {
        let nothing = |_| Waits { deadline: Cell::new(NEVER), reply: Cell::new(ANY) };
        Shared {
            now: Cell::new(0),
            ready: PlaceCells::default(),
            waits: (0..MAX_PROCESSES).map(nothing).collect(),
            closing: Cell::new(false),
        }
    }

    /// A request has come for a process.
    fn wake(&self, process: usize) {
        self.ready.insert(process);
    }

    /// The reply of a port has come for a process.
    fn wake_by_reply(&self, process: usize, port: usize) {
        let reply = self.waits[process].reply.get();
        if reply == ANY || reply == port {
            self.ready.insert(process);
        }
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
    /// How many ports there are.
    ports: usize,
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
        Scheduler { shared: Rc::new(Shared::new()), ports: 0, processes: Vec::new(), pulse: None }
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
        Box::new(move |places| shared.ready.insert_all(places))
    }

    /// Runs all processes to their end.
    ///
    /// # Errors
    /// [`Stuck`] when none can run and none waits for a time.
    pub fn run(mut self) -> Result<Nanos, Stuck> {
        overflow::listen();
        let running = Running::begin();
        let outcome = self.run_until_closing(&running);
        self.shared.closing.set(true);
        // Every wait now returns at once: bodies run to their end, whatever they were waiting for.
        for _ in 0..CLOSING_RESUMES {
            let mut alive = false;
            for place in 0..self.processes.len() {
                alive |= self.resume(place, &running);
            }
            if !alive {
                break;
            }
        }
        running.leave();
        // What still runs ignores the closing. Its stack is given up: unwinding it could be caught again.
        for (_, process) in &mut self.processes {
            core::mem::forget(process.take());
        }
        outcome.map(|()| self.shared.now.get())
    }

    fn run_until_closing(&mut self, running: &Running) -> Result<(), Stuck> {
        while !self.shared.closing.get() {
            match self.shared.ready.take_first() {
                Some(place) => drop(self.resume(place, running)),
                None => self.advance()?,
            }
        }
        Ok(())
    }

    /// Resumes a process; whether it is still alive.
    fn resume(&mut self, place: usize, running: &Running) -> bool {
        let Some((process, guard)) = &mut self.processes[place].1 else { return false };
        if let Some(pulse) = &self.pulse {
            pulse.place.store(place, Ordering::Relaxed);
            pulse.resumed.fetch_add(1, Ordering::Relaxed);
        }
        guard.enter(running);
        match process.resume(()) {
            CoroutineResult::Yield(()) => true,
            CoroutineResult::Return(()) => {
                running.leave();
                self.processes[place].1 = None;
                self.shared.waits[place].deadline.set(NEVER);
                false
            }
        }
    }

    /// Moves the clock to the earliest deadline.
    fn advance(&self) -> Result<(), Stuck> {
        let waits = &self.shared.waits[..self.processes.len()];
        let next = waits.iter().map(|waits| waits.deadline.get()).min().unwrap_or(NEVER);
        if next == NEVER {
            let alive = self.processes.iter().filter(|(_, process)| process.is_some());
            let names: Vec<_> = alive.map(|(name, _)| name.as_str()).collect();
            return Err(Stuck::Deadlock(names.join(", ")));
        }
        self.shared.now.set(next);
        for (place, waits) in waits.iter().enumerate() {
            if waits.deadline.get() <= next {
                self.shared.wake(place);
            }
        }
        Ok(())
    }
}

impl Link for Scheduler {
    fn place(&mut self, process: ProcessId) -> usize {
        assert!(self.processes.len() < MAX_PROCESSES, "a cell has at most {MAX_PROCESSES} processes");
        self.processes.push((process.to_string(), None));
        self.processes.len() - 1
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

impl MemoryWaiter<'_> {
    /// Lets other processes run until a time, or until a message comes that wakes this one.
    fn suspend(&self, deadline: Option<Nanos>, reply: usize) -> Result<(), Closed> {
        let shared = &*self.shared;
        let deadline = deadline.unwrap_or(NEVER);
        if deadline > shared.now.get() && !shared.closing.get() {
            let waits = &shared.waits[self.place];
            waits.deadline.set(deadline);
            waits.reply.set(reply);
            self.yielder.suspend(());
            waits.deadline.set(NEVER);
            waits.reply.set(ANY);
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
