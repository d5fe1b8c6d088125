//! Links: how the processes of a cell reach one another.
//!
//! A process waits in one place, its [`Waiter`]; messages go through request-reply ports (Send-Receive-Reply
//! of the paper), and a free-running virtual sensor shows its last reading on a board. User programs never see
//! which link they run on.

pub mod envelope;
pub mod memory;
pub mod message;
pub mod numbering;
mod overflow;
pub mod patience;
pub mod places;
pub mod watchdog;

use std::rc::Rc;

use crate::link::message::Message;
use crate::model::fault::ProcessId;

pub use crate::model::time::{Clock, Nanos};
use crate::operator::console::{Console, NoConsole};

pub use memory::Stuck;

/// The cell is closing: the process returns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Closed;

/// Where a process waits.
pub trait Waiter {
    /// Time now.
    fn now(&self) -> Nanos;

    /// Waits until a message has come for this process, or until `deadline`; it may wake without either.
    ///
    /// # Errors
    /// [`Closed`] when the cell is closing.
    fn wait(&self, deadline: Option<Nanos>) -> Result<(), Closed>;

    /// The same until the reply of a port has come: messages of other ports may or may not wake the process.
    ///
    /// # Errors
    /// [`Closed`] when the cell is closing.
    fn wait_for_reply(&self, _client: &dyn Client, deadline: Option<Nanos>) -> Result<(), Closed> {
        self.wait(deadline)
    }

    /// Whether time stands still while a process runs, as under the memory link's virtual clock: then nothing that a process
    /// does makes it late.
    fn stands_still(&self) -> bool {
        false
    }

    /// In lock-step: lets the process at a place run until it waits, as if it were a part of this one.
    ///
    /// # Errors
    /// [`Closed`] when the cell is closing.
    fn call(&self, _place: usize) -> Result<(), Closed> {
        Ok(())
    }

    /// Waits until a time although the cell is closing: a robot that still moves is braked first.
    ///
    /// # Errors
    /// [`Closed`] where time stands still then, as the virtual clock's does.
    fn wait_closing(&self, _until: Nanos) -> Result<(), Closed> {
        Err(Closed)
    }
}

/// Counts what a process takes, where anybody wants to know.
pub trait Meter {
    /// The time that the process itself took since it was asked last, for work between its waits and for waking late; 0
    /// where that is not measured \[ns\].
    fn own_time(&self) -> Nanos {
        0
    }

    /// Counts something of this process.
    fn sample(&self, _sample: Sample) {}
}

/// What happens outside of the cell's own messages.
pub trait Notices {
    /// What has happened, once.
    fn news(&self) -> Option<News> {
        None
    }

    /// Whether who started the cell still watches over its processes.
    fn is_supervised(&self) -> bool {
        true
    }
}

/// Of a link on which nothing is counted and nothing happens outside of the cell.
#[derive(Clone, Copy, Debug, Default)]
pub struct Nothing;

impl Meter for Nothing {}
impl Notices for Nothing {}

/// What a process has of the link that it runs on.
#[derive(Clone, Copy)]
pub struct Host<'w> {
    /// Where it waits.
    pub waiter: &'w dyn Waiter,
    /// What counts the time that it takes.
    pub meter: &'w dyn Meter,
    /// What an MP is told from outside of its cell.
    pub notices: &'w dyn Notices,
    /// Where an MP meets its operator.
    pub console: &'w dyn Console,
}

impl<'w> Host<'w> {
    /// Of a link that lets processes wait, and no more.
    #[must_use]
    pub fn of(waiter: &'w dyn Waiter) -> Host<'w> {
        Host { waiter, meter: &Nothing, notices: &Nothing, console: &NoConsole }
    }
}

/// What is counted of a process.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sample {
    /// A step or a servo period began so much after it was due \[ns\].
    Late(Nanos),
    /// The process took so much time of its own for it \[ns\].
    Worked(Nanos),
    /// So many periods were left out.
    Skipped(u64),
}

/// What an MP is told from outside of its cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum News {
    /// A process of the cell is gone.
    Lost(ProcessId),
    /// The operator aborts.
    Abort,
}

/// The asking end of a request-reply port.
pub trait Client {
    /// Sends a request; an unanswered earlier one is replaced.
    fn send(&self, request: &Message);

    /// Sends the last request again, if it has no answer: it may have been lost, or its answer. It is done once all the
    /// same. A link that loses nothing has nothing to do.
    fn send_again(&self) {}

    /// Takes the reply, if it is there.
    fn receive(&self, reply: &mut Message) -> bool;

    /// What its link knows the port by, where the link can wake a process for one port alone.
    fn port(&self) -> Option<usize> {
        None
    }
}

/// The answering end of a request-reply port.
pub trait Server {
    /// Takes the request, if one is there.
    fn receive(&self, request: &mut Message) -> bool;

    /// Answers the request taken last.
    fn reply(&self, reply: &Message);
}

/// The last message of a free-running process.
pub trait Board {
    /// Shows a message.
    fn write(&self, message: &Message);

    /// Reads the message shown last; `false` when there was none yet.
    fn read(&self, message: &mut Message) -> bool;
}

/// A process's body. It runs once the link does, and cannot keep what it is given.
pub type Body = Box<dyn for<'w> FnOnce(Host<'w>)>;

/// Where the simulated drives of a cell are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Simulation {
    /// Each in its EDP.
    InEdps,
    /// All in a process of their own, which does a servo period when it is asked to: under the virtual clock.
    Asked,
    /// All in a process of their own, which has its own clock, takes the newest commands and shows what it reads.
    Free,
}

/// Where the processes of a cell are put. The same calls in the same order make the same cell, wherever they run.
pub trait Link {
    /// A place for a process, which ports can name before its body is known.
    fn place(&mut self, process: ProcessId) -> usize;

    /// A request-reply port between two places.
    fn port(&mut self, client: usize, server: usize) -> (Box<dyn Client>, Box<dyn Server>);

    /// A board that one place writes and another one reads.
    fn board(&mut self, writer: usize, reader: usize) -> Rc<dyn Board>;

    /// Gives the process at `place` its body.
    ///
    /// # Errors
    /// [`Stuck`] when it cannot have one.
    fn body(&mut self, place: usize, body: Body) -> Result<(), Stuck>;

    /// Where it puts simulated drives.
    fn simulation(&self) -> Simulation {
        Simulation::InEdps
    }

    /// What closes the cell when the MP's program is over: every wait returns [`Closed`] from then on.
    fn closer(&self) -> Box<dyn Fn()>;
}
