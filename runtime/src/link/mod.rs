//! Links: how the processes of a cell reach one another.
//!
//! A process waits in one place, its [`Waiter`]; messages go through request-reply ports (Send-Receive-Reply
//! of the paper), and a free-running virtual sensor shows its last reading on a board. User programs never see
//! which link they run on.

pub mod memory;

use crate::message::Message;

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
