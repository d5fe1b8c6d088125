//! Links: how the processes of a cell reach one another.
//!
//! A process waits in one place, its [`Waiter`]; messages go through request-reply ports (Send-Receive-Reply
//! of the paper), and a free-running virtual sensor shows its last reading on a board. User programs never see
//! which link they run on.

pub(crate) mod envelope;
#[cfg(all(feature = "processes", target_os = "linux"))]
pub mod iceoryx;
pub mod memory;
pub mod watchdog;

use std::rc::Rc;

use crate::fault::ProcessId;
use crate::message::Message;

use memory::Stuck;

/// Monotonic time since the cell started \[ns\].
pub type Nanos = u64;

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

    /// Waits until a time although the cell is closing: a robot that still moves is braked first.
    ///
    /// # Errors
    /// [`Closed`] where time stands still then, as the virtual clock's does.
    fn wait_closing(&self, _until: Nanos) -> Result<(), Closed> {
        Err(Closed)
    }

    /// What has happened outside of the cell's own messages, once.
    fn news(&self) -> Option<News> {
        None
    }
}

/// What an MP is told from outside of its cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(
    not(all(feature = "processes", target_os = "linux")),
    allow(dead_code, reason = "told to processes")
)]
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

    /// Takes the reply, if it is there.
    fn receive(&self, reply: &mut Message) -> bool;
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

/// A process's body. It runs once the link does, and cannot keep the waiter.
pub type Body = Box<dyn for<'w> FnOnce(&'w dyn Waiter)>;

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

    /// What closes the cell when the MP's program is over: every wait returns [`Closed`] from then on.
    fn closer(&self) -> Box<dyn Fn()>;
}
