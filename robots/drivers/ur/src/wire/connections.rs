//! A controller in a network: its connections, and what the drives want of them.
//!
//! In: what the drives tell, the time, and what comes over connections. Out: states, where the script is, how far jobs have come.

use core::time::Duration;
use std::io::ErrorKind;
use std::net::{IpAddr, SocketAddr};

use mrroc_driver_kit::{Cutting, RefusedCounts};

use super::network::{Connection, Listener, Network, Received, Tcp};
use super::primary::{self, Reading};
use super::rtde::{self, Negotiated, Negotiation, state_of};
use super::running::{Addresses, CALL, Running};
use super::{ConnectionLost, Job, JobState, TimedState, Wire};
use crate::calibration::Calibration;
use crate::outputs::{Group, Groups};
use crate::rtde::{Answer, Package, Request};
use crate::script::Ended;
use crate::set_point::SetPoint;
use crate::state::State;
use crate::stop::Connected;

/// What a program node says that asks for a script, and the most bytes of a line that is waited for.
const ASKS: &[u8] = b"request_program\n";
const LONGEST: usize = 64;

/// How often it is looked for what a controller says that is waited for.
const LOOK: Duration = Duration::from_micros(200);

/// How much time passes while the drives wait for a job.
const STEP: Duration = Duration::from_millis(1);

/// The ports of a controller. Their defaults are those of every robot; others are for tests.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Ports {
    /// Of the dashboard, 29999.
    pub dashboard: u16,
    /// Of the interface that tells the calibration, 30001.
    pub primary: u16,
    /// Of the interface that takes scripts, 30002.
    pub secondary: u16,
    /// Of RTDE, 30004.
    pub rtde: u16,
}

impl Default for Ports {
    fn default() -> Self {
        Ports { dashboard: 29999, primary: 30001, secondary: 30002, rtde: 30004 }
    }
}

/// Connections with a controller over the sockets of this machine.
pub type Sockets = Connections<Tcp>;

/// Connections with a controller in the network `N`: RTDE, the script's, and, for jobs, the dashboard and the interface that takes scripts.
#[derive(Debug)]
pub struct Connections<N: Network> {
    network: N,
    robot: IpAddr,
    listen: SocketAddr,
    ports: Ports,
    rtde: Option<(N::Connection, u8)>,
    /// The recipes by which outputs of the groups are switched.
    written: [Option<u8>; 2],
    /// A message to be sent: its place is there before the cell runs.
    bytes: Vec<u8>,
    listener: Option<N::Listener>,
    script: Option<N::Connection>,
    connected: Connected,
    job: Option<Running<N>>,
    node: Option<Node<N>>,
}

/// Where a program node asks for the script.
#[derive(Debug)]
struct Node<N: Network> {
    at: SocketAddr,
    listener: Option<N::Listener>,
    connection: Option<N::Connection>,
    offers: String,
}

impl<N: Network> Node<N> {
    /// Gives the script to a node that asks for it. It waits for nothing.
    fn serve(&mut self) {
        if let Some(connection) = self.listener.as_mut().and_then(Listener::accept) {
            self.connection = Some(connection);
        }
        let Some(connection) = &mut self.connection else { return };
        while let Some(asks) = connection.oldest().map(|line| line.bytes == ASKS) {
            if asks && !self.offers.is_empty() {
                // A node that has gone away asks again.
                let _ = connection.send(self.offers.as_bytes());
            }
        }
        if !connection.is_open() {
            self.connection = None;
        }
    }
}

impl Sockets {
    /// A controller at `robot`, which calls this machine at `listen`. Nothing is connected yet.
    #[must_use]
    pub fn new(robot: IpAddr, listen: SocketAddr, ports: Ports) -> Sockets {
        Connections::over(Tcp::new(), robot, listen, ports)
    }
}

impl<N: Network> Connections<N> {
    /// The same in another network, with its clock: with a model of a controller in the same process.
    #[must_use]
    pub fn over(network: N, robot: IpAddr, listen: SocketAddr, ports: Ports) -> Connections<N> {
        Connections {
            network,
            robot,
            listen,
            ports,
            rtde: None,
            written: [None; 2],
            bytes: Vec::with_capacity(64),
            listener: None,
            script: None,
            connected: Connected::NotYet,
            job: None,
            node: None,
        }
    }

    /// The same, where a program node asks for the script at this address of this machine.
    #[must_use]
    pub fn asked_at(mut self, at: Option<SocketAddr>) -> Connections<N> {
        self.node = at.map(|at| Node { at, listener: None, connection: None, offers: String::new() });
        self
    }

    /// Where a program node asks for the script, while that is possible: the port that was found, where 0 was asked for.
    #[must_use]
    pub fn node(&self) -> Option<SocketAddr> {
        self.node.as_ref()?.listener.as_ref().map(Listener::address)
    }

    /// What was not taken of what came to this machine's port; `None` while it is closed.
    #[must_use]
    pub fn refused(&self) -> Option<RefusedCounts> {
        self.listener.as_ref().map(Listener::refused)
    }

    /// Opens the ports at which the controller calls.
    fn listen(&mut self) -> Result<(), ConnectionLost> {
        let listener = self.network.listen(self.listen, self.robot, |bytes| match bytes.len() {
            0..Ended::BYTES => Cutting::More,
            _ => Cutting::Frame(Ended::BYTES),
        });
        let lost = |_| ConnectionLost("this machine has no such address, or its port is taken");
        self.listener = Some(listener.map_err(lost)?);
        if let Some(node) = &mut self.node {
            let listener = self.network.listen(node.at, self.robot, |bytes| {
                match bytes.iter().position(|byte| *byte == b'\n') {
                    Some(end) => Cutting::Frame(end + 1),
                    None if bytes.len() < LONGEST => Cutting::More,
                    None => Cutting::Bad,
                }
            });
            let lost = |_| {
                ConnectionLost(
                    "the port at which External Control asks for its script is taken on this machine",
                )
            };
            node.listener = Some(listener.map_err(lost)?);
        }
        Ok(())
    }

    /// Calls the controller at this port, and waits until it has answered.
    fn call(&mut self, port: u16, timeout: Duration, cut: mrroc_driver_kit::Cut) -> Option<N::Connection> {
        let mut call = self.network.call(SocketAddr::new(self.robot, port), timeout, cut);
        loop {
            match self.network.called(&mut call) {
                Some(called) => return called.ok(),
                None => self.network.wait(LOOK),
            }
        }
    }

    /// Waits until something has become of what comes over a connection.
    fn until<T>(
        &mut self,
        connection: &mut N::Connection,
        mut poll: impl FnMut(Duration, Option<&[u8]>, bool, &mut Vec<u8>) -> Result<Option<T>, ConnectionLost>,
    ) -> Result<T, ConnectionLost> {
        let mut requests = Vec::new();
        loop {
            let (now, is_open) = (self.network.now(), connection.is_open());
            let received = connection.oldest();
            let had_any = received.is_some();
            let outcome = poll(now, received.map(|received| received.bytes), is_open, &mut requests)?;
            if let Some(outcome) = outcome {
                return Ok(outcome);
            }
            if !requests.is_empty() {
                connection.send(&requests).map_err(|_| rtde::CLOSED)?;
                requests.clear();
            }
            if !had_any {
                self.network.wait(LOOK);
            }
        }
    }
}

impl<N: Network> Wire for Connections<N> {
    fn hardware(&self) -> Option<String> {
        Some(format!("Universal Robots {} at {}", self.robot, self.listen))
    }

    fn reverse(&self) -> SocketAddr {
        self.listener.as_ref().map_or(self.listen, Listener::address)
    }

    fn connect(&mut self, switches: Groups) -> Result<State, ConnectionLost> {
        self.disconnect();
        self.listen()?;
        let called = self.call(self.ports.rtde, CALL, rtde::cut);
        let mut connection =
            called.ok_or(ConnectionLost("nobody answers at its address: is it switched on?"))?;
        let mut request = Vec::new();
        let mut negotiation = Negotiation::begin(self.network.now(), switches, &mut request);
        connection.send(&request).map_err(|_| rtde::CLOSED)?;
        let Negotiated { recipe, written, state } = self
            .until(&mut connection, |now, package, is_open, requests| {
                negotiation.poll(now, package, is_open, requests)
            })?;
        (self.rtde, self.written) = (Some((connection, recipe)), written);
        Ok(state)
    }

    fn switch(&mut self, group: Group, values: &[u8]) {
        let (Some((connection, _)), Some(recipe)) = (&mut self.rtde, self.written[group as usize]) else {
            return;
        };
        self.bytes.clear();
        Request::Data { recipe, values }.write(&mut self.bytes);
        // A connection that is lost is told when it is heard.
        let _ = connection.send(&self.bytes);
    }

    fn calibration(&mut self) -> Result<Calibration, ConnectionLost> {
        let called = self.call(self.ports.primary, primary::TIMEOUT, primary::cut);
        let mut connection = called.ok_or(primary::ABSENT)?;
        let reading = Reading::new(self.network.now());
        self.until(&mut connection, |now, message, is_open, _| reading.poll(now, message, is_open))
    }

    fn disconnect(&mut self) {
        (self.job, self.script, self.rtde, self.listener) = (None, None, None, None);
        if let Some(node) = &mut self.node {
            (node.listener, node.connection) = (None, None);
        }
        self.connected = Connected::NotYet;
    }

    fn heard(&mut self, _: Duration) -> Result<Option<TimedState>, ConnectionLost> {
        if let Some(node) = &mut self.node {
            node.serve();
        }
        let Some((connection, recipe)) = &mut self.rtde else {
            return Err(ConnectionLost("RTDE is not connected"));
        };
        while let Some(Received { bytes, age }) = connection.oldest() {
            let Ok(Some((package, _))) = Package::first(bytes) else { continue };
            let state = Answer::read(&package).and_then(|answer| state_of(&answer, *recipe));
            if let Some(state) = state {
                return Ok(Some(TimedState { state, age }));
            }
        }
        if connection.is_open() { Ok(None) } else { Err(rtde::CLOSED) }
    }

    fn tell(&mut self, message: &SetPoint) -> bool {
        let Some(connection) = &mut self.script else { return false };
        let was_open = connection.is_open();
        let sent = connection.send(&message.bytes());
        // The network takes no more: set-points have been on their way for so long that the script brakes, but what it says of
        // that is not heard any more.
        if was_open && sent.as_ref().is_err_and(|why| why.kind() == ErrorKind::WouldBlock) {
            self.connected = Connected::Ended(Some(Ended::Timeout));
        }
        sent.is_ok()
    }

    fn script(&mut self) -> Connected {
        let Some(connection) = &mut self.script else { return self.connected };
        // What it says last comes before the end.
        let is_open = connection.is_open();
        while let Some(frame) = connection.oldest() {
            if let Some(ended) = Ended::read(frame.bytes) {
                self.connected = Connected::Ended(Some(ended));
            }
        }
        if !is_open && self.connected == Connected::Yes {
            self.connected = Connected::Ended(None);
        }
        self.connected
    }

    fn hang_up(&mut self) {
        self.script = None;
        self.connected = Connected::NotYet;
    }

    fn begin(&mut self, job: Job) {
        // The one that goes on ends.
        self.job = None;
        if !matches!(job, Job::Unlock) {
            self.hang_up();
            // A call that nobody asked for; one of a script that was asked for by a node may have come before the reset.
            if !matches!(job, Job::Offer(_)) {
                drop(self.listener.as_mut().and_then(Listener::accept));
            }
        }
        if let (Job::Offer(script), Some(node)) = (&job, &mut self.node) {
            node.offers.clone_from(script);
        }
        let addresses = Addresses {
            dashboard: SocketAddr::new(self.robot, self.ports.dashboard),
            secondary: SocketAddr::new(self.robot, self.ports.secondary),
        };
        self.job = Some(Running::begin(&mut self.network, job, addresses, self.node.is_some()));
    }

    fn job(&mut self) -> JobState {
        let Some(job) = &mut self.job else { return JobState::None };
        let mut state = job.poll(&mut self.network);
        if state == JobState::Busy && job.starts {
            let call = self.listener.as_mut().and_then(Listener::accept);
            if let Some(connection) = call.filter(Connection::is_open) {
                (self.script, self.connected) = (Some(connection), Connected::Yes);
                state = JobState::Done;
            }
        }
        if state == JobState::Busy {
            state = job.late(self.network.now()).unwrap_or(JobState::Busy);
        }
        if state != JobState::Busy {
            self.job = None;
        }
        state
    }

    fn wait(&mut self) {
        self.network.wait(STEP);
    }
}
