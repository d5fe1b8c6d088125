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
pub mod places;
pub mod timeout;
pub mod watchdog;

use std::rc::Rc;

use crate::link::message::Message;
use crate::model::fault::ProcessId;

pub use crate::model::time::{Clock, Nanos};
use crate::operator::console::{Console, NoConsole};

pub use memory::Stuck;

/// The cell is closing, and the process must return.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Closed;

/// Where a process waits.
pub trait Waiter {
    /// Time now.
    fn now(&self) -> Nanos;

    /// Waits until a message has come for this process, or until `deadline`. It may also return before either.
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

    /// Waits and works in turn until the cell is closing, of a process that only serves: first until `first`, then until the
    /// time that its last `turn` has returned, each time at most until a message has come.
    ///
    /// A link may call `turn` on the stack of another process: it must not wait.
    fn serve(&self, first: Nanos, turn: &mut dyn FnMut() -> Nanos) {
        let mut deadline = first;
        while self.wait(Some(deadline)).is_ok() {
            deadline = turn();
        }
    }

    /// Whether time stands still while a process runs, as under the memory link's virtual clock: then nothing that a process
    /// does makes it late.
    fn stands_still(&self) -> bool {
        false
    }

    /// In lock-step: runs the process at a place until it waits, as if it were a part of the calling process.
    ///
    /// # Errors
    /// [`Closed`] when the cell is closing.
    fn call(&self, _place: usize) -> Result<(), Closed> {
        Ok(())
    }

    /// Waits until a time even while the cell is closing, so that a robot that still moves can be braked first.
    ///
    /// # Errors
    /// [`Closed`] if time does not go on while the cell is closing, as under the virtual clock.
    fn wait_closing(&self, _until: Nanos) -> Result<(), Closed> {
        Err(Closed)
    }
}

/// Measures the time that a process takes, on links that report it.
pub trait Meter {
    /// The time \[ns\] that the process itself has taken since the last call, for work between its waits and for waking
    /// late; 0 if that is not measured.
    fn own_time(&self) -> Nanos {
        0
    }

    /// Adds a sample of this process.
    fn sample(&self, _sample: Sample) {}
}

/// Events that the cell's own messages do not tell of.
pub trait Notices {
    /// An event that has happened; each is returned once.
    fn news(&self) -> Option<News> {
        None
    }

    /// Whether the launcher of the cell still supervises its processes.
    fn is_supervised(&self) -> bool {
        true
    }
}

/// The stops that consoles ask for where every process sees it, past the launcher.
pub trait StopBoard {
    /// How many were asked for: the uppermost MP and all EDPs look in each period.
    fn asked(&self) -> u64 {
        0
    }

    /// How many of them the MP has begun to carry out.
    fn begun(&self) -> u64 {
        0
    }

    /// Shows how many the MP has begun to carry out, and in which step; `None`: the cell was in the fault state already.
    fn show_begun(&self, _stops: u64, _step: Option<u64>) {}
}

/// The meter, the notices and the stops of a link that measures nothing and has no events.
#[derive(Clone, Copy, Debug, Default)]
pub struct Nothing;

impl Meter for Nothing {}
impl Notices for Nothing {}
impl StopBoard for Nothing {}

/// What a link provides to a process that runs on it.
#[derive(Clone, Copy)]
pub struct Host<'w> {
    /// Where it waits.
    pub waiter: &'w dyn Waiter,
    /// What counts the time that it takes.
    pub meter: &'w dyn Meter,
    /// What an MP is told from outside of its cell.
    pub notices: &'w dyn Notices,
    /// The stops that consoles ask for past the launcher.
    pub stops: &'w dyn StopBoard,
    /// The consoles of the cell's operator.
    pub console: &'w dyn Console,
}

impl<'w> Host<'w> {
    /// The host of a link that only lets processes wait.
    #[must_use]
    pub fn of(waiter: &'w dyn Waiter) -> Host<'w> {
        Host { waiter, meter: &Nothing, notices: &Nothing, stops: &Nothing, console: &NoConsole }
    }
}

/// A measurement of a process.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sample {
    /// A step or a servo period began this long after it was due \[ns\].
    Late(Nanos),
    /// The process itself took this long for a step or a servo period \[ns\].
    Worked(Nanos),
    /// This many periods were left out.
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

    /// Sends the last request again if it has no answer, because the request or its answer may have been lost. The
    /// server carries it out only once. Links that lose nothing need not implement this.
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

/// Holds the last message of a free-running process.
pub trait Board {
    /// Shows a message.
    fn write(&self, message: &Message);

    /// Reads the message shown last; `false` if there is none yet.
    fn read(&self, message: &mut Message) -> bool;
}

/// The code of a process. It runs when the link runs, and cannot keep its [`Host`].
pub type Body = Box<dyn for<'w> FnOnce(Host<'w>)>;

/// What a process does before the cell begins.
pub trait Preparation {
    /// Connects to what it drives; it may take seconds. What fails then is told by the process when it runs. The second call
    /// does nothing.
    fn open(&self);

    /// Keeps that connected, between `open` and the process's body; called about twice in a millisecond.
    fn keep(&self);
}

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

/// A link onto which the processes of a cell are put. The same calls in the same order make the same cell on every
/// link.
pub trait Link {
    /// Makes a place for a process, so that ports can name the process before its body is known.
    fn place(&mut self, process: ProcessId) -> usize;

    /// A request-reply port between two places.
    fn port(&mut self, client: usize, server: usize) -> (Box<dyn Client>, Box<dyn Server>);

    /// A board that one place writes and another one reads.
    fn board(&mut self, writer: usize, reader: usize) -> Rc<dyn Board>;

    /// Gives the process at `place` its body.
    ///
    /// # Errors
    /// [`Stuck`] if the process cannot have one.
    fn body(&mut self, place: usize, body: Body) -> Result<(), Stuck>;

    /// What the process at `place` does before the cell begins. Links on which a process may take any time when it begins
    /// need not implement this: the body does it then.
    fn prepare(&mut self, _place: usize, _preparation: Rc<dyn Preparation>) {}

    /// Whether the process at `place` runs in this process of the operating system.
    fn is_here(&self, _place: usize) -> bool {
        true
    }

    /// Where it puts simulated drives.
    fn simulation(&self) -> Simulation {
        Simulation::InEdps
    }

    /// A function that closes the cell when the MP's program is over: from then on every wait returns [`Closed`].
    fn closer(&self) -> Box<dyn Fn()>;
}
