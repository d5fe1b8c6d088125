//! The memory link: every process is a stackful coroutine on one thread, under a virtual clock.
//!
//! The clock stands while any process can run and then jumps to the earliest deadline, so a run is as fast as
//! the processor goes and the same to the bit every time: processes run in the order of their places.
//!
//! A process that waits for a reply runs the others itself, in that same order, until it is its turn again: mostly the one
//! that it asks, and then it goes on without a switch back to the scheduler. The process that the scheduler runs, mostly the
//! MP, lets time pass itself as well.
//!
//! A process that only serves ([`Waiter::serve`]), as an EDP does, is not resumed for each of its turns: whoever waits takes
//! them on its own stack, and who asks it has the answer at once.

use crate::link::Host;
use core::any::Any;
use core::cell::{Cell, OnceCell, RefCell};
use core::panic::AssertUnwindSafe;
use core::ptr::NonNull;
use std::rc::Rc;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};

use corosensei::stack::DefaultStack;
use corosensei::{Coroutine, CoroutineResult, Yielder};

use super::overflow::{self, Guard};
use super::places::{MAX_PROCESSES, PlaceCells, Places};
use super::{Board, Body, Client, Closed, Link, Nanos, Server, Waiter};
use crate::link::message::Message;
use crate::model::fault::{ProcessId, Role};

/// Stack of a process \[bytes\]; pages are used only when touched, and a guard page ends the stack ([`overflow`]).
const STACK: usize = 1 << 20;

const NEVER: Nanos = Nanos::MAX;

/// How often a process that ignores the closing of the cell is resumed before its stack is given up.
const CLOSING_RESUMES: u32 = 10_000;

type Process = Coroutine<(), (), (), DefaultStack>;

/// What a process does that serves, until it waits again; it returns when the process wants to wake at the latest.
type Turn = NonNull<dyn FnMut() -> Nanos>;

/// Whether a process serves.
#[derive(Clone, Copy)]
enum Serving {
    /// It does not, or takes a turn on its own stack.
    No,
    /// Its coroutine is suspended in [`Waiter::serve`]: what it does when it wakes.
    Waits(Turn),
    /// Its turn is being taken, mostly on the stack of another process.
    Works,
}

/// A process, and what it waits for.
struct Seat {
    /// Its coroutine, unless it is over or has none yet. Borrowed while it runs, or waits on a stack below the one that runs.
    process: RefCell<Option<Process>>,
    guard: OnceCell<Guard>,
    /// The port whose reply alone wakes it; [`ANY`]: every message does.
    reply: Cell<usize>,
    serving: Cell<Serving>,
    /// What ended a turn, for its coroutine.
    panic: Cell<Option<Box<dyn Any + Send>>>,
}

impl Seat {
    fn empty() -> Seat {
        Seat {
            process: RefCell::new(None),
            guard: OnceCell::new(),
            reply: Cell::new(ANY),
            serving: Cell::new(Serving::No),
            panic: Cell::new(None),
        }
    }

    /// Whether it runs, or waits on a stack below the one that runs, or its turn is being taken there.
    fn runs(&self) -> bool {
        self.works() || self.process.try_borrow().is_err()
    }

    /// Whether its turn is being taken.
    fn works(&self) -> bool {
        matches!(self.serving.get(), Serving::Works)
    }
}

/// Every message wakes the process.
const ANY: usize = usize::MAX;

/// No reply does.
const NONE: usize = usize::MAX - 1;

/// The state that scheduler, waiters and ports share.
struct Shared {
    now: Cell<Nanos>,
    /// The processes that have something to do.
    ready: PlaceCells,
    /// The virtual sensors.
    sensors: PlaceCells,
    /// The processes, by their places, and how many places are taken.
    seats: Box<[Seat]>,
    taken: Cell<usize>,
    /// When the processes wake at the latest: together, because all of them are looked at whenever time goes on.
    deadlines: Box<[Cell<Nanos>]>,
    /// The process that the scheduler has resumed: all others run on the stack of one that waits.
    lowest: Cell<usize>,
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
            sensors: PlaceCells::default(),
            seats: (0..MAX_PROCESSES).map(|_| Seat::empty()).collect(),
            taken: Cell::new(0),
            deadlines: vec![Cell::new(NEVER); MAX_PROCESSES].into(),
            lowest: Cell::new(MAX_PROCESSES),
            closing: Cell::new(false),
            pulse: OnceCell::new(),
            panic: Cell::new(None),
        }
    }

    /// A request has come for a process.
    #[inline]
    fn wake(&self, process: usize) {
        self.ready.insert(process);
    }

    /// The reply of a port has come for a process.
    #[inline]
    fn wake_by_reply(&self, process: usize, port: usize) {
        let reply = self.seats[process].reply.get();
        if reply == ANY || reply == port {
            self.ready.insert(process);
        }
    }

    /// Runs a process until it waits, on a stack of its own; whether it is still alive.
    fn resume(&self, place: usize) -> bool {
        let seat = &self.seats[place];
        if seat.works() {
            // Its coroutine has lent the turn, and must not use what the turn has borrowed.
            return false;
        }
        let Ok(mut process) = seat.process.try_borrow_mut() else { return false };
        let (Some(coroutine), Some(guard)) = (process.as_mut(), seat.guard.get()) else { return false };
        self.show(place);
        let below = guard.enter();
        let result = coroutine.resume(());
        drop(below);
        let is_alive = matches!(result, CoroutineResult::Yield(()));
        if !is_alive {
            *process = None;
            self.deadlines[place].set(NEVER);
        }
        is_alive
    }

    /// Takes the turn of a process that serves, on the stack of whoever calls this.
    #[inline]
    fn take_turn(&self, place: usize, mut turn: Turn) {
        let seat = &self.seats[place];
        self.show(place);
        let below = seat.guard.get().map(Guard::lend);
        // It is not there to be taken again by what it does, as by a request to itself.
        seat.serving.set(Serving::Works);
        // SAFETY: the process's coroutine is suspended in `serve`, which has borrowed the turn mutably and forgets it here
        // before it goes on or is unwound. `resume` does not let it go on while `serving` is `Works`, and nobody else has the
        // pointer: so the turn is not entered twice at once.
        #[allow(unsafe_code)]
        let taken = std::panic::catch_unwind(AssertUnwindSafe(|| unsafe { turn.as_mut()() }));
        drop(below);
        match taken {
            Ok(deadline) => {
                seat.serving.set(Serving::Waits(turn));
                self.sleep(place, deadline);
            }
            Err(panic) => {
                seat.serving.set(Serving::No);
                // It unwinds its own stack, and not that of who took the turn.
                seat.panic.set(Some(panic));
                self.resume(place);
            }
        }
    }

    /// A process that serves wakes at this time.
    #[inline]
    fn sleep(&self, place: usize, deadline: Nanos) {
        self.deadlines[place].set(deadline);
        if deadline <= self.now.get() {
            self.ready.insert(place);
        }
    }

    /// Runs a process until it waits, on the stack of a process that waits.
    #[inline]
    fn run(&self, place: usize) {
        self.ready.remove(place);
        match self.seats[place].serving.get() {
            Serving::Waits(turn) => self.take_turn(place, turn),
            Serving::No | Serving::Works => drop(self.resume(place)),
        }
    }

    /// Shows the watchdog that the process at a place runs from now on.
    #[inline]
    fn show(&self, place: usize) {
        if let Some(pulse) = self.pulse.get() {
            pulse.place.store(place, Ordering::Relaxed);
            // Nobody else writes it: no need to keep the processor's other cores from it.
            let resumed = pulse.resumed.load(Ordering::Relaxed);
            pulse.resumed.store(resumed.wrapping_add(1), Ordering::Relaxed);
        }
    }

    /// Runs the processes that are ready, as the scheduler would, until it is the turn of the one at `place`, which calls
    /// this. Whether that has come: not where none is ready, or where it is the turn of one on a stack below.
    fn run_others(&self, place: usize) -> bool {
        while !self.closing.get() {
            let Some(first) = self.ready.first() else {
                // On the lowest stack nobody below waits for a time, and the scheduler does nothing else.
                if self.lowest.get() == place && self.advance() {
                    continue;
                }
                return false;
            };
            if first == place {
                self.ready.remove(place);
                self.show(place);
                return true;
            }
            if self.seats[first].runs() {
                return false;
            }
            self.run(first);
        }
        false
    }

    /// A request has come at a port. A server that serves takes its turn at once, unless a virtual sensor is to work: its
    /// reading is there first, as if all had waited for their turns. Others are woken.
    #[inline]
    fn ask(&self, port: &Port) {
        let is_free = !self.closing.get() && !self.ready.meets(&self.sensors);
        let Serving::Waits(turn) = self.seats[port.server].serving.get() else {
            return self.wake(port.server);
        };
        if !is_free {
            return self.wake(port.server);
        }
        // The client finds the reply when it goes on from here: it need not be woken for it.
        let client = &self.seats[port.client];
        let reply = client.reply.replace(NONE);
        self.take_turn(port.server, turn);
        client.reply.set(reply);
        self.show(port.client);
    }

    /// Moves the clock to the earliest deadline, if there is one.
    fn advance(&self) -> bool {
        let deadlines = &self.deadlines[..self.taken.get()];
        let next = deadlines.iter().fold(NEVER, |next, deadline| next.min(deadline.get()));
        if next == NEVER {
            return false;
        }
        self.now.set(next);
        for (place, deadline) in deadlines.iter().enumerate() {
            if deadline.get() == next {
                self.ready.insert(place);
            }
        }
        true
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
            core::mem::forget(seat.process.take());
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
                    shared.lowest.set(place);
                    shared.resume(place);
                }
                None if shared.advance() => {}
                None => return Err(self.deadlock()),
            }
        }
        Ok(())
    }

    /// Nobody can run, and nobody waits for a time.
    fn deadlock(&self) -> Stuck {
        let named = self.names.iter().zip(&self.shared.seats);
        let alive = named.filter(|(_, seat)| seat.process.borrow().is_some());
        let names: Vec<_> = alive.map(|(name, _)| name.as_str()).collect();
        Stuck::Deadlock(names.join(", "))
    }
}

impl Drop for Scheduler {
    /// The processes keep what they share, and it keeps them.
    fn drop(&mut self) {
        for seat in &self.shared.seats {
            drop(seat.process.take());
        }
    }
}

impl Link for Scheduler {
    fn place(&mut self, process: ProcessId) -> usize {
        assert!(self.names.len() < MAX_PROCESSES, "a cell has at most {MAX_PROCESSES} processes");
        if process.role == Role::Vsp {
            self.shared.sensors.insert(self.names.len());
        }
        self.names.push(process.to_string());
        self.shared.taken.set(self.names.len());
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
            let run = AssertUnwindSafe(|| body(Host::of(&waiter)));
            if let Err(panic) = std::panic::catch_unwind(run) {
                // On another process's stack it would be that one's.
                let first = waiter.shared.panic.take().unwrap_or(panic);
                waiter.shared.panic.set(Some(first));
                waiter.shared.closing.set(true);
            }
        });
        let seat = &self.shared.seats[place];
        // A place has one body.
        let _ = seat.guard.set(guard);
        seat.process.replace(Some(process));
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
    fn seat(&self) -> &Seat {
        &self.shared.seats[self.place]
    }

    /// Lets other processes run until a time, or until a message comes that wakes this one.
    fn suspend(&self, deadline: Option<Nanos>, reply: usize) -> Result<(), Closed> {
        let (shared, seat) = (&*self.shared, self.seat());
        if seat.works() {
            // In its turn it cannot.
            return Err(Closed);
        }
        let deadline = deadline.unwrap_or(NEVER);
        if deadline > shared.now.get() && !shared.closing.get() {
            shared.deadlines[self.place].set(deadline);
            seat.reply.set(reply);
            let runs_others = reply != ANY || shared.lowest.get() == self.place;
            if !(runs_others && shared.run_others(self.place)) {
                self.yielder.suspend(());
            }
            shared.deadlines[self.place].set(NEVER);
            seat.reply.set(ANY);
        }
        if shared.closing.get() { Err(Closed) } else { Ok(()) }
    }
}

impl Waiter for MemoryWaiter<'_> {
    #[inline]
    fn now(&self) -> Nanos {
        self.shared.now.get()
    }

    fn wait(&self, deadline: Option<Nanos>) -> Result<(), Closed> {
        self.suspend(deadline, ANY)
    }

    fn wait_for_reply(&self, client: &dyn Client, deadline: Option<Nanos>) -> Result<(), Closed> {
        self.suspend(deadline, client.port().unwrap_or(ANY))
    }

    fn serve(&self, first: Nanos, turn: &mut dyn FnMut() -> Nanos) {
        let (shared, seat) = (&*self.shared, self.seat());
        if seat.works() {
            // In a turn it cannot wait; and on the stack of another process its own is suspended already.
            return;
        }
        shared.sleep(self.place, first);
        let forgets = Forgets(&seat.serving);
        while !shared.closing.get() {
            // SAFETY: only a lifetime is left out, and the pointer is forgotten before that ends: `Forgets` does so also where
            // this is unwound. A coroutine that is given up is leaked with its stack, on which the turn and what it borrows are.
            #[allow(unsafe_code)]
            let lasting: &mut (dyn FnMut() -> Nanos + 'static) = unsafe { core::mem::transmute(&mut *turn) };
            seat.serving.set(Serving::Waits(NonNull::from(lasting)));
            self.yielder.suspend(());
            seat.serving.set(Serving::No);
            if let Some(panic) = seat.panic.take() {
                std::panic::resume_unwind(panic);
            }
            if !shared.closing.get() {
                // On its own stack, and yet as anywhere: in a turn nobody waits.
                seat.serving.set(Serving::Works);
                let deadline = turn();
                seat.serving.set(Serving::No);
                shared.sleep(self.place, deadline);
            }
        }
        drop(forgets);
        shared.deadlines[self.place].set(NEVER);
    }

    fn stands_still(&self) -> bool {
        true
    }
}

/// Forgets a turn whose process goes on, or is unwound.
struct Forgets<'s>(&'s Cell<Serving>);

impl Drop for Forgets<'_> {
    fn drop(&mut self) {
        self.0.set(Serving::No);
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
        port.shared.ask(port);
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
