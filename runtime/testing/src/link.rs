//! A link with a fault: the memory link, with decorators on its ports, its boards and its processes' waiters.
//!
//! In: a cell and a case. Out: the same cell on a link that has the fault of the case.

use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::rc::Rc;

use super::case::Channel;
use super::channel::{Direction, FaultyBoard, faulty_port};
use super::stage::{NEVER, Stage};
use mrroc_core::fault::ProcessId;
use mrroc_core::link::memory::{Scheduler, Stuck};
use mrroc_core::link::{Board, Body, Client, Closed, Host, Link, Nanos, Server, Waiter};

/// The memory link with the fault of a case.
pub(super) struct FaultyLink<'s> {
    pub scheduler: &'s mut Scheduler,
    pub stage: Rc<Stage>,
}

impl FaultyLink<'_> {
    fn process(&self, place: usize) -> ProcessId {
        self.stage.processes.borrow()[place]
    }

    fn direction(&self, from: usize, to: usize) -> Direction {
        Direction::new(&self.stage, Channel { from: self.process(from), to: self.process(to) }, to)
    }
}

impl Link for FaultyLink<'_> {
    fn place(&mut self, process: ProcessId) -> usize {
        self.stage.processes.borrow_mut().push(process);
        self.stage.due.borrow_mut().push(NEVER);
        self.scheduler.place(process)
    }

    fn port(&mut self, client: usize, server: usize) -> (Box<dyn Client>, Box<dyn Server>) {
        let ends = self.scheduler.port(client, server);
        let (requests, replies) = (self.direction(client, server), self.direction(server, client));
        let (client, server) = faulty_port(ends, requests, replies);
        (Box::new(client), Box::new(server))
    }

    fn board(&mut self, writer: usize, reader: usize) -> Rc<dyn Board> {
        let channel = self.direction(writer, reader);
        Rc::new(FaultyBoard { channel, shown: Default::default(), sent: Default::default() })
    }

    fn body(&mut self, place: usize, body: Body) -> Result<(), Stuck> {
        let (stage, process) = (Rc::clone(&self.stage), self.process(place));
        let close = self.scheduler.closer();
        let run = move |host: Host<'_>| {
            let waiter = FaultyWaiter { inner: host.waiter, stage: &stage, place, process, close: &*close };
            stage.fork();
            match catch_unwind(AssertUnwindSafe(|| body(Host { waiter: &waiter, ..host }))) {
                Err(panic) if !panic.is::<Killed>() => resume_unwind(panic),
                Err(_) => {}
                Ok(()) => {
                    // The robots are watched for some time after the MP's program is over.
                    if process == ProcessId::MP {
                        waiter.linger();
                    }
                }
            }
        };
        self.scheduler.body(place, Box::new(run))
    }

    fn closer(&self) -> Box<dyn Fn()> {
        let stage = Rc::clone(&self.stage);
        Box::new(move || stage.over.set(Some(stage.now.get())))
    }
}

/// The payload of the panic that unwinds a killed process, when the cell is closed and nothing reads its messages.
struct Killed;

/// The waiter of a process, which stalls or kills the process when the case says so.
struct FaultyWaiter<'w> {
    inner: &'w dyn Waiter,
    stage: &'w Stage,
    place: usize,
    process: ProcessId,
    close: &'w dyn Fn(),
}

impl FaultyWaiter<'_> {
    fn look_at_clock(&self) -> Nanos {
        let now = self.inner.now();
        self.stage.now.set(now);
        now
    }

    /// Sleeps for the time that the trial lasts after the MP's end, then closes the cell.
    fn linger(&self) {
        let until = self.look_at_clock() + self.stage.lasting.get().afterwards * self.stage.step;
        while self.inner.now() < until && self.inner.wait(Some(until)).is_ok() {}
        (self.close)();
    }

    /// A dead process does nothing more; if it is the MP, it closes the cell in the end, as the launcher would.
    fn stay_dead(&self) -> Closed {
        if self.process == ProcessId::MP {
            self.stage.over.set(Some(self.stage.now.get()));
            self.linger();
        }
        while self.inner.wait(None).is_ok() {}
        if !std::thread::panicking() {
            resume_unwind(Box::new(Killed));
        }
        Closed
    }

    fn stand_still(&self) -> Result<(), Closed> {
        while let Some(until) = self.stage.still_until(self.process) {
            if until == NEVER {
                return Err(self.stay_dead());
            }
            while self.look_at_clock() < until {
                self.inner.wait(Some(until))?;
            }
        }
        Ok(())
    }
}

impl Waiter for FaultyWaiter<'_> {
    fn now(&self) -> Nanos {
        self.inner.now()
    }

    fn wait(&self, deadline: Option<Nanos>) -> Result<(), Closed> {
        let due = core::mem::replace(&mut self.stage.due.borrow_mut()[self.place], NEVER);
        let deadline = deadline.unwrap_or(NEVER).min(due);
        let waited = self.inner.wait((deadline < NEVER).then_some(deadline));
        let now = self.look_at_clock();
        waited?;
        self.stage.fork();
        let lasting = self.stage.lasting.get();
        let is_over = |steps: u64| now > steps.saturating_mul(self.stage.step);
        let (given_up, cut) = (is_over(lasting.most), is_over(lasting.watched));
        if given_up || cut {
            self.stage.given_up.set(given_up);
            self.stage.cut.set(!given_up);
            (self.close)();
            return Err(Closed);
        }
        self.stand_still()
    }

    fn wait_closing(&self, until: Nanos) -> Result<(), Closed> {
        self.inner.wait_closing(until)
    }
}
