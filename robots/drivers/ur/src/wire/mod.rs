//! How the drives reach their controller.
//!
//! In: set-points, the script, commands of an operator's reset. Out: the controller's state in every period. Nothing here
//! waits but [`Wire::connect`], [`Wire::calibration`] and [`Wire::wait`], which are called while the cell does not run. [`Sockets`] are the real
//! ones: [`Connections`] over [`Tcp`]. Over another [`Network`] they reach a model of a controller in the same process, under a clock of
//! its own; another `Wire` may do so without any protocol but RTDE's and the script's.

mod connections;
mod dashboard;
mod network;
mod primary;
mod rtde;
mod running;

use core::time::Duration;

use crate::calibration::Calibration;
use crate::outputs::{Group, Groups};
use crate::set_point::SetPoint;
use crate::state::State;
use crate::stop::Connected;

pub use connections::{Connections, Ports, Sockets};
pub use network::{Connection, Listener, Network, Received, Tcp, TcpCall, TcpConnection, TcpPort};

/// A state, and how long it has been here.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TimedState {
    /// What the controller says.
    pub state: State,
    /// Since it came in.
    pub age: Duration,
}

/// The connection is lost, or was never there: why, for a message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ConnectionLost(pub &'static str);

/// What takes longer than a period.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Job {
    /// Sends this script, and waits until it has called.
    Start(String),
    /// Gives this script to a program node of the pendant that asks for it, and waits until it has called.
    Offer(String),
    /// Releases a protective stop and closes its window at the pendant.
    Unlock,
}

/// How far a job has come.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum JobState {
    /// There is none.
    None,
    /// It goes on.
    Busy,
    /// It is done.
    Done,
    /// The controller is not in remote control, and takes no commands over the network.
    Local,
    /// It could not be done: why.
    Refused(&'static str),
}

/// A connection with a controller.
pub trait Wire {
    /// The name of the hardware, unique on this machine; `None` if any number of cells may use it.
    fn hardware(&self) -> Option<String>;

    /// Where the script calls.
    fn reverse(&self) -> std::net::SocketAddr;

    /// Connects, if that has not been done, and returns the first state. It may take seconds. `switches`: of which groups
    /// outputs are going to be switched, which one program at a time may do.
    ///
    /// # Errors
    /// Why it cannot be reached, or that another program switches its outputs.
    fn connect(&mut self, switches: Groups) -> Result<State, ConnectionLost>;

    /// Switches outputs of a group: the values of its [names](Group::names).
    fn switch(&mut self, group: Group, values: &[u8]);

    /// The calibration of its arm. It needs no connection but its own, and may take seconds.
    ///
    /// # Errors
    /// Why it cannot be read.
    fn calibration(&mut self) -> Result<Calibration, ConnectionLost>;

    /// Lets the controller go.
    fn disconnect(&mut self);

    /// The oldest state that came by `now`, the time since the cell started, and has not been heard.
    ///
    /// # Errors
    /// The connection is lost.
    fn heard(&mut self, now: Duration) -> Result<Option<TimedState>, ConnectionLost>;

    /// Tells the script this; whether it took it.
    fn tell(&mut self, message: &SetPoint) -> bool;

    /// Where the script is.
    fn script(&mut self) -> Connected;

    /// Closes the connection of the script, which then ends.
    fn hang_up(&mut self);

    /// Begins a job, in place of one that goes on.
    fn begin(&mut self, job: Job);

    /// How far the job has come. Done or refused is said once.
    fn job(&mut self) -> JobState;

    /// Lets a little time pass, in which a job goes on.
    fn wait(&mut self);
}
