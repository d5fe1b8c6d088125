//! The connections of a controller, once in each of its periods.
//!
//! In: clients that call, and what they say. Out: what the controller answers and tells. No client is waited for, and one that does not read
//! what it is told is cut off. Nothing here has a clock or a socket: both are of the network that is handed in.

use std::io::{ErrorKind, Read, Write};
use std::net::SocketAddr;

use mrroc_ur::SET_POINT_BYTES;
use mrroc_ur::rtde::{Package, Request};

use crate::controller::Controller;
use crate::dashboard::GREETING;
use crate::external::{ASKS, Answered, Asking};
use crate::primary::EVERY;
use crate::session::Session;

/// The most bytes of a script, and of what waits to be sent to a client.
const MOST: usize = 256 * 1024;

/// What of a controller is called.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Interface {
    /// Commands of persons, in lines of text.
    Dashboard,
    /// The calibration and the state, and scripts.
    Primary,
    /// Scripts.
    Secondary,
    /// Outputs and inputs.
    Rtde,
}

/// The network in which a controller is. Nothing here waits for long; a stream that has nothing, or takes nothing, says
/// [`WouldBlock`](ErrorKind::WouldBlock).
pub(crate) trait Network {
    /// A connection.
    type Stream: Read + Write;

    /// The next that calls this interface.
    fn accept(&mut self, interface: Interface) -> Option<Self::Stream>;

    /// Calls this address, if it may be called and somebody is there.
    fn call(&mut self, to: SocketAddr) -> Option<Self::Stream>;
}

/// A client: what has come of it, and what waits to be sent.
pub(crate) struct Client<S> {
    stream: S,
    came: Vec<u8>,
    waits: Vec<u8>,
    is_open: bool,
}

impl<S: Read + Write> Client<S> {
    fn new(stream: S) -> Client<S> {
        Client { stream, came: Vec::new(), waits: Vec::new(), is_open: true }
    }

    /// Takes what has come.
    fn read(&mut self) {
        let mut bytes = [0; 4096];
        while self.is_open {
            match self.stream.read(&mut bytes) {
                Ok(0) => self.is_open = false,
                Ok(len) => self.came.extend_from_slice(&bytes[..len]),
                Err(why) if why.kind() == ErrorKind::WouldBlock => break,
                Err(why) if why.kind() == ErrorKind::Interrupted => {}
                Err(_) => self.is_open = false,
            }
            self.is_open &= self.came.len() <= MOST;
        }
    }

    /// Sends what waits, as far as the other end takes it.
    fn write(&mut self) {
        while self.is_open && !self.waits.is_empty() {
            match self.stream.write(&self.waits) {
                Ok(0) => self.is_open = false,
                Ok(len) => drop(self.waits.drain(..len)),
                Err(why) if why.kind() == ErrorKind::WouldBlock => break,
                Err(why) if why.kind() == ErrorKind::Interrupted => {}
                Err(_) => self.is_open = false,
            }
        }
        self.is_open &= self.waits.len() <= MOST;
    }

    /// The line at the front of what has come.
    fn line(&mut self) -> Option<String> {
        let end = self.came.iter().position(|byte| *byte == b'\n')?;
        let line: Vec<u8> = self.came.drain(..=end).collect();
        Some(String::from_utf8_lossy(&line).into_owned())
    }

    /// What is asked for at the front of what has come: a line, or a script, up to the line with the `end` of its `def`.
    fn asked(&mut self) -> Option<Asked> {
        if !self.came.starts_with(b"def ") && !self.came.starts_with(b"sec ") {
            return self.line().map(Asked::Line);
        }
        let end = self.came.windows(5).position(|five| five == b"\nend\n")?;
        let script: Vec<u8> = self.came.drain(..end + 5).collect();
        Some(Asked::Script(String::from_utf8_lossy(&script).into_owned()))
    }
}

/// What a client of the primary or the secondary interface asks for.
enum Asked {
    Line(String),
    Script(String),
}

/// All connections in a network, once in a period.
pub(crate) struct Service<N: Network> {
    pub network: N,
    dashboards: Vec<Client<N::Stream>>,
    primaries: Vec<Client<N::Stream>>,
    secondaries: Vec<Client<N::Stream>>,
    rtde: Vec<(Client<N::Stream>, Session)>,
    reverse: Option<Client<N::Stream>>,
    /// Connections that a script has beside it.
    others: Vec<Client<N::Stream>>,
    /// The program node that has asked for a script.
    node: Option<(Client<N::Stream>, Asking)>,
}

impl<N: Network> Service<N> {
    /// Nobody is connected.
    pub fn new(network: N) -> Service<N> {
        Service {
            network,
            dashboards: Vec::new(),
            primaries: Vec::new(),
            secondaries: Vec::new(),
            rtde: Vec::new(),
            reverse: None,
            others: Vec::new(),
            node: None,
        }
    }

    /// Those that call one of the interfaces now.
    fn accepted(&mut self, interface: Interface) -> Vec<Client<N::Stream>> {
        core::iter::from_fn(|| self.network.accept(interface)).map(Client::new).collect()
    }

    /// One period of the controller; `watch` sees it after its step.
    pub fn period(&mut self, controller: &mut Controller, watch: &mut dyn FnMut(&Controller)) {
        self.serve_dashboards(controller);
        self.serve_scripts(controller);
        self.serve_node(controller);
        self.serve_requests(controller);
        self.take_set_points(controller);
        controller.step();
        watch(controller);
        self.tell(controller);
        self.serve_reverse(controller);
    }

    fn serve_dashboards(&mut self, controller: &mut Controller) {
        let mut accepted = self.accepted(Interface::Dashboard);
        accepted.iter_mut().for_each(|client| client.waits.extend(format!("{GREETING}\n").bytes()));
        self.dashboards.append(&mut accepted);
        for client in &mut self.dashboards {
            client.read();
            while let Some(line) = client.line() {
                client.waits.extend(format!("{}\n", controller.dashboard(&line)).bytes());
            }
            client.write();
        }
        self.dashboards.retain(|client| client.is_open);
    }

    fn serve_scripts(&mut self, controller: &mut Controller) {
        let mut accepted = self.accepted(Interface::Secondary);
        self.secondaries.append(&mut accepted);
        let mut accepted = self.accepted(Interface::Primary);
        accepted.iter_mut().for_each(|client| client.waits.extend(controller.greets()));
        self.primaries.append(&mut accepted);
        if controller.steps.is_multiple_of(EVERY) && !self.primaries.is_empty() {
            let state = controller.primary_state();
            self.primaries.iter_mut().for_each(|client| client.waits.extend(&state));
        }
        for client in self.secondaries.iter_mut().chain(&mut self.primaries) {
            client.read();
            while let Some(asked) = client.asked() {
                match asked {
                    Asked::Script(script) => drop(controller.take_script(&script)),
                    // What is none is left out, as a controller does.
                    Asked::Line(line) => drop(controller.primary_line(&line)),
                }
            }
            client.write();
        }
        self.secondaries.retain(|client| client.is_open);
        self.primaries.retain(|client| client.is_open);
    }

    /// The node of a program that has been started asks for its script. Without an answer the program has nothing to do, and ends.
    fn serve_node(&mut self, controller: &mut Controller) {
        if let Some(at) = controller.asks() {
            self.node = self.network.call(at).map(|stream| {
                let mut client = Client::new(stream);
                client.waits.extend(ASKS);
                (client, Asking::default())
            });
        }
        let Some((client, asking)) = &mut self.node else { return };
        client.write();
        client.read();
        match asking.poll(&client.came, client.is_open) {
            Answered::NotYet => return,
            Answered::Nothing => {}
            Answered::Script(text) => drop(controller.take_answer(&text)),
        }
        self.node = None;
    }

    fn serve_requests(&mut self, controller: &mut Controller) {
        let accepted = self.accepted(Interface::Rtde);
        self.rtde.extend(accepted.into_iter().map(|client| (client, Session::new(controller))));
        for (client, session) in &mut self.rtde {
            client.read();
            let came = core::mem::take(&mut client.came);
            let mut rest = &came[..];
            loop {
                match Package::first(rest) {
                    Ok(Some((package, after))) => {
                        match Request::read(&package) {
                            Some(request) => session.request(controller, &request, &mut client.waits),
                            None => client.is_open = false,
                        }
                        rest = after;
                    }
                    Ok(None) => break,
                    Err(_) => {
                        client.is_open = false;
                        break;
                    }
                }
            }
            client.came = rest.to_vec();
            client.write();
        }
        self.rtde.retain(|(client, session)| {
            if !client.is_open {
                session.end(controller);
            }
            client.is_open
        });
    }

    fn take_set_points(&mut self, controller: &mut Controller) {
        let Some(client) = &mut self.reverse else { return };
        client.read();
        let mut rest = &client.came[..];
        while let Some((message, after)) = rest.split_first_chunk::<SET_POINT_BYTES>() {
            controller.take_set_point(message);
            rest = after;
        }
        client.came = rest.to_vec();
        if !client.is_open {
            controller.hung_up();
        }
    }

    fn tell(&mut self, controller: &Controller) {
        for (client, session) in &mut self.rtde {
            session.outputs(controller, &mut client.waits);
            client.write();
        }
    }

    /// The script's connection: a new one is called, what it says is sent, and it is closed when it has ended.
    fn serve_reverse(&mut self, controller: &mut Controller) {
        if let Some(ended) = controller.says()
            && let Some(client) = &mut self.reverse
        {
            client.waits.extend(ended.bytes());
            client.write();
        }
        if let Some(address) = controller.calls() {
            let mut call = |at: SocketAddr| self.network.call(at).map(Client::new);
            let before: Option<Vec<_>> = controller.others().iter().map(|at| call(*at)).collect();
            let reverse = before.is_some().then(|| call(address)).flatten();
            (self.others, self.reverse) = (before.unwrap_or_default(), reverse);
            controller.connected(self.reverse.is_some());
        } else if !controller.is_connected() {
            self.reverse = None;
            self.others.clear();
        }
        for client in &mut self.others {
            // What is asked for there is not done here.
            client.read();
            client.came.clear();
        }
    }
}
