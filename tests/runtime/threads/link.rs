//! The processes of a cell as threads of which one runs at a time, under a virtual clock: the plainest scheduler that there can be.
//!
//! In: the bodies of processes. Out: their run. Whoever waits gives the turn back; the scheduler gives it to the lowest place that is ready,
//! or else lets time go on to the earliest deadline. No process works on the stack of another one.

use std::cell::RefCell;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::rc::Rc;
use std::sync::{Arc, Condvar, Mutex, MutexGuard};
use std::thread::JoinHandle;

use mrroc::fault::ProcessId;
use mrroc::link::memory::{MemoryBoard, Stuck};
use mrroc::link::message::Message;
use mrroc::link::{Board, Body, Client, Closed, Host, Link, Nanos, Server, Waiter};

const NEVER: Nanos = Nanos::MAX;

/// Whose turn it is when it is that of no process.
const SCHEDULER: usize = usize::MAX;

/// What all threads know.
#[derive(Default)]
struct State {
    now: Nanos,
    ready: Vec<bool>,
    deadlines: Vec<Nanos>,
    over: Vec<bool>,
    turn: usize,
    closing: bool,
}

/// The turn, and what goes with it.
#[derive(Default)]
struct Turn {
    state: Mutex<State>,
    moved: Condvar,
}

impl Turn {
    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().expect("nobody panics with it")
    }

    fn give(&self, to: usize) {
        self.state().turn = to;
        self.moved.notify_all();
    }

    fn wait_for(&self, place: usize) {
        drop(
            self.moved.wait_while(self.state(), |state| state.turn != place).expect("nobody panics with it"),
        );
    }
}

/// What a process does, until its thread has it.
struct Carried(Body);

// SAFETY: bodies share reference counts. Only the thread whose turn it is touches them, and the lock of the turn orders what the threads
// do.
#[allow(unsafe_code)]
unsafe impl Send for Carried {}

impl Carried {
    fn run(self, host: Host<'_>) {
        (self.0)(host);
    }
}

/// The link.
#[derive(Default)]
pub struct Threads {
    turn: Arc<Turn>,
    threads: Vec<Option<JoinHandle<()>>>,
}

impl Threads {
    /// Runs all processes to their end; the time then.
    pub fn run(mut self) -> Nanos {
        let turn = Arc::clone(&self.turn);
        while let Some(next) = next(&turn) {
            turn.give(next);
            turn.wait_for(SCHEDULER);
        }
        assert!(turn.state().over.iter().all(|over| *over), "a deadlock");
        for thread in self.threads.iter_mut().filter_map(Option::take) {
            thread.join().unwrap_or_else(|panic| resume_unwind(panic));
        }
        turn.state().now
    }
}

/// Whose turn is next.
fn next(turn: &Turn) -> Option<usize> {
    let mut state = turn.state();
    loop {
        let places = 0..state.over.len();
        if state.closing {
            return places.into_iter().find(|&place| !state.over[place]);
        }
        if let Some(place) = places.into_iter().find(|&place| state.ready[place] && !state.over[place]) {
            state.ready[place] = false;
            return Some(place);
        }
        let earliest = state.deadlines.iter().copied().min().filter(|&deadline| deadline < NEVER)?;
        state.now = earliest;
        for place in 0..state.deadlines.len() {
            state.ready[place] |= state.deadlines[place] == earliest;
        }
    }
}

impl Link for Threads {
    fn place(&mut self, _: ProcessId) -> usize {
        let mut state = self.turn.state();
        state.turn = SCHEDULER;
        state.ready.push(false);
        state.deadlines.push(NEVER);
        state.over.push(true);
        self.threads.push(None);
        self.threads.len() - 1
    }

    fn port(&mut self, client: usize, server: usize) -> (Box<dyn Client>, Box<dyn Server>) {
        let turn = Arc::clone(&self.turn);
        let port =
            Rc::new(Port { request: RefCell::default(), reply: RefCell::default(), client, server, turn });
        (Box::new(Asks(Rc::clone(&port))), Box::new(Answers(port)))
    }

    fn board(&mut self, _: usize, _: usize) -> Rc<dyn Board> {
        Rc::new(MemoryBoard::default())
    }

    fn body(&mut self, place: usize, body: Body) -> Result<(), Stuck> {
        let (turn, body) = (Arc::clone(&self.turn), Carried(body));
        {
            let mut state = turn.state();
            state.ready[place] = true;
            state.over[place] = false;
        }
        self.threads[place] = Some(std::thread::spawn(move || {
            turn.wait_for(place);
            let waiter = Waits { turn: Arc::clone(&turn), place };
            let ran = catch_unwind(AssertUnwindSafe(|| body.run(Host::of(&waiter))));
            {
                let mut state = turn.state();
                state.over[place] = true;
                state.deadlines[place] = NEVER;
                state.closing |= ran.is_err();
            }
            turn.give(SCHEDULER);
            if let Err(panic) = ran {
                resume_unwind(panic);
            }
        }));
        Ok(())
    }

    fn closer(&self) -> Box<dyn Fn()> {
        let turn = Arc::clone(&self.turn);
        Box::new(move || turn.state().closing = true)
    }
}

/// How a process waits.
struct Waits {
    turn: Arc<Turn>,
    place: usize,
}

impl Waiter for Waits {
    fn now(&self) -> Nanos {
        self.turn.state().now
    }

    fn wait(&self, deadline: Option<Nanos>) -> Result<(), Closed> {
        let deadline = deadline.unwrap_or(NEVER);
        let mut state = self.turn.state();
        if deadline > state.now && !state.closing {
            state.deadlines[self.place] = deadline;
            drop(state);
            self.turn.give(SCHEDULER);
            self.turn.wait_for(self.place);
            state = self.turn.state();
        }
        state.deadlines[self.place] = NEVER;
        if state.closing { Err(Closed) } else { Ok(()) }
    }

    fn stands_still(&self) -> bool {
        true
    }
}

/// A place for one request and one for its reply.
struct Port {
    request: RefCell<Option<Message>>,
    reply: RefCell<Option<Message>>,
    client: usize,
    server: usize,
    turn: Arc<Turn>,
}

struct Asks(Rc<Port>);

struct Answers(Rc<Port>);

fn take(from: &RefCell<Option<Message>>, into: &mut Message) -> bool {
    from.take().is_some_and(|message| {
        into.copy_from(&message);
        true
    })
}

impl Client for Asks {
    fn send(&self, request: &Message) {
        self.0.reply.replace(None);
        self.0.request.replace(Some(*request));
        self.0.turn.state().ready[self.0.server] = true;
    }

    fn receive(&self, reply: &mut Message) -> bool {
        take(&self.0.reply, reply)
    }
}

impl Server for Answers {
    fn receive(&self, request: &mut Message) -> bool {
        take(&self.0.request, request)
    }

    fn reply(&self, reply: &Message) {
        self.0.reply.replace(Some(*reply));
        self.0.turn.state().ready[self.0.client] = true;
    }
}
