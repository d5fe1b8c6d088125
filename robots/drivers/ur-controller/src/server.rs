//! The controller on sockets, in real time.
//!
//! In: connections of clients. Out: what the controller answers and tells. One thread serves all of them once in a period; no client
//! is waited for, and one that does not read what it is told is cut off.

#![expect(clippy::disallowed_methods, reason = "it keeps real time")]

use std::io::{self, ErrorKind, Read, Write};
use std::net::{IpAddr, SocketAddr, TcpListener, TcpStream};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, Sender, TryRecvError, channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use mrroc_robots::Six;
use mrroc_ur::rtde::{Package, Request};
use mrroc_ur::{PERIOD, Ports, SET_POINT_BYTES, UrModel};

use crate::controller::Controller;
use crate::dashboard::GREETING;
use crate::external;
use crate::primary::EVERY;
use crate::session::Session;

/// The most bytes of a script, and of what waits to be sent to a client.
const MOST: usize = 256 * 1024;

/// How long the other end of a script may take to answer its call.
const CALL: Duration = Duration::from_millis(200);

/// Sees the controller after every period.
type Watch = Box<dyn FnMut(&Controller) + Send>;

/// Is done between two periods.
type Look = Box<dyn FnOnce(&mut Controller) + Send>;

/// Where it listens: the ports that were found, where 0 was asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Listening {
    /// Its address.
    pub address: IpAddr,
    /// Its ports, as a driver needs them. The primary interface tells the calibration, and takes scripts as the secondary one does.
    pub ports: Ports,
}

/// A controller that serves clients until it is let go.
///
/// ```
/// use mrroc_robots::Six;
/// use mrroc_ur::{Ports, UrModel};
/// use mrroc_ur_controller::Server;
///
/// // Ports that the system gives; `Ports::default()` are those of a robot.
/// let free = Ports { dashboard: 0, primary: 0, secondary: 0, rtde: 0 };
/// let server = Server::start(UrModel::Ur5e, Six::zeros(), "127.0.0.1".parse()?, free)?;
/// assert_ne!(server.listening().ports.rtde, 0);
/// server.with(|controller| controller.set_digital_inputs(0b1));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct Server {
    looks: Sender<Look>,
    listening: Listening,
    ends: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Server {
    /// Serves at `address`, on these ports, a controller whose arm stands at `start` \[rad\].
    ///
    /// # Errors
    /// The address is none of this machine, or a port is taken; or a thread cannot be started.
    pub fn start(model: UrModel, start: Six, address: IpAddr, ports: Ports) -> io::Result<Server> {
        Server::watched(model, start, address, ports, Box::new(|_| ()))
    }

    /// The same, and `watch` sees the controller after every period.
    ///
    /// # Errors
    /// As [`Server::start`].
    pub fn watched(
        model: UrModel,
        start: Six,
        address: IpAddr,
        ports: Ports,
        watch: Watch,
    ) -> io::Result<Server> {
        let bind = |port| {
            let listener = TcpListener::bind(SocketAddr::new(address, port))?;
            listener.set_nonblocking(true)?;
            io::Result::Ok((listener.local_addr()?.port(), listener))
        };
        let (dashboard, dashboards) = bind(ports.dashboard)?;
        let (secondary, secondaries) = bind(ports.secondary)?;
        let (primary, primaries) = bind(ports.primary)?;
        let (rtde, rtdes) = bind(ports.rtde)?;
        let listening = Listening { address, ports: Ports { dashboard, primary, secondary, rtde } };
        let ends = Arc::<AtomicBool>::default();
        let service = Service {
            dashboards: (dashboards, Vec::new()),
            secondaries,
            primaries: (primaries, Vec::new()),
            scripts: Vec::new(),
            rtde: (rtdes, Vec::new()),
            reverse: None,
            others: Vec::new(),
            asked: None,
            address,
            watch,
        };
        let (looks, asked) = channel();
        let over = Arc::clone(&ends);
        let thread = std::thread::Builder::new().name("controller".to_owned()).spawn(move || {
            // The arms of all models are made: a test of `mrroc-ur` makes them.
            if let Ok(controller) = Controller::new(model, &start) {
                serve(service, controller, &asked, &over);
            }
        })?;
        Ok(Server { looks, listening, ends, thread: Some(thread) })
    }

    /// Where it listens.
    #[must_use]
    pub fn listening(&self) -> Listening {
        self.listening
    }

    /// Looks at the controller between two periods, or presses something; `None` if it serves no more.
    pub fn with<T: Send + 'static>(
        &self,
        look: impl FnOnce(&mut Controller) -> T + Send + 'static,
    ) -> Option<T> {
        let (seen, sees) = channel();
        let look: Look = Box::new(move |controller| drop(seen.send(look(controller))));
        self.looks.send(look).ok()?;
        sees.recv().ok()
    }
}

/// Serves in every period, until it is over.
fn serve(mut service: Service, mut controller: Controller, asked: &Receiver<Look>, over: &AtomicBool) {
    let mut due = Instant::now();
    while !over.load(Ordering::Acquire) {
        service.period(&mut controller);
        while let Ok(look) = asked.try_recv() {
            look(&mut controller);
        }
        // Its clock is the count of its periods: one that comes late puts off all that follow.
        let now = Instant::now();
        due = (due + PERIOD).max(now);
        std::thread::sleep(due - now);
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        self.ends.store(true, Ordering::Release);
        // A thread that panicked has nothing left to end.
        let _ = self.thread.take().map(JoinHandle::join);
    }
}

/// A client: what has come of it, and what waits to be sent.
struct Client {
    stream: TcpStream,
    came: Vec<u8>,
    waits: Vec<u8>,
    is_open: bool,
}

impl Client {
    fn new(stream: TcpStream) -> io::Result<Client> {
        stream.set_nonblocking(true)?;
        stream.set_nodelay(true)?;
        Ok(Client { stream, came: Vec::new(), waits: Vec::new(), is_open: true })
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

/// All connections.
struct Service {
    dashboards: (TcpListener, Vec<Client>),
    secondaries: TcpListener,
    primaries: (TcpListener, Vec<Client>),
    scripts: Vec<Client>,
    rtde: (TcpListener, Vec<(Client, Session)>),
    reverse: Option<Client>,
    /// Connections that a script has beside it.
    others: Vec<Client>,
    /// The script that a program node has asked for.
    asked: Option<Receiver<String>>,
    address: IpAddr,
    watch: Watch,
}

fn accepted(listener: &TcpListener) -> impl Iterator<Item = Client> {
    core::iter::from_fn(|| listener.accept().ok()).filter_map(|(stream, _)| Client::new(stream).ok())
}

impl Service {
    fn period(&mut self, controller: &mut Controller) {
        self.serve_dashboards(controller);
        self.serve_scripts(controller);
        self.serve_node(controller);
        self.serve_requests(controller);
        self.take_set_points(controller);
        controller.step();
        (self.watch)(controller);
        self.tell(controller);
        self.serve_reverse(controller);
    }

    fn serve_dashboards(&mut self, controller: &mut Controller) {
        let (listener, clients) = &mut self.dashboards;
        clients.extend(accepted(listener).map(|mut client| {
            client.waits.extend(format!("{GREETING}\n").bytes());
            client
        }));
        for client in clients.iter_mut() {
            client.read();
            while let Some(line) = client.line() {
                client.waits.extend(format!("{}\n", controller.dashboard(&line)).bytes());
            }
            client.write();
        }
        clients.retain(|client| client.is_open);
    }

    fn serve_scripts(&mut self, controller: &mut Controller) {
        self.scripts.extend(accepted(&self.secondaries));
        let (listener, clients) = &mut self.primaries;
        clients.extend(accepted(listener).map(|mut client| {
            client.waits.extend(controller.greets());
            client
        }));
        if controller.steps.is_multiple_of(EVERY) && !clients.is_empty() {
            let state = controller.primary_state();
            clients.iter_mut().for_each(|client| client.waits.extend(&state));
        }
        for client in self.scripts.iter_mut().chain(clients.iter_mut()) {
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
        self.scripts.retain(|client| client.is_open);
        clients.retain(|client| client.is_open);
    }

    /// The node of a program that has been started asks for its script, on a thread that may wait.
    fn serve_node(&mut self, controller: &mut Controller) {
        if let Some(at) = controller.asks().filter(|at| self.may_call(*at)) {
            let (sender, asked) = channel();
            let thread = std::thread::Builder::new().name("program node".to_owned());
            // Without an answer the program has nothing to do, and ends.
            let ask = move || external::ask(at).map(|text| drop(sender.send(text)));
            self.asked = thread.spawn(ask).is_ok().then_some(asked);
        }
        match self.asked.as_ref().map(Receiver::try_recv) {
            Some(Ok(text)) => {
                controller.take_answer(&text);
                self.asked = None;
            }
            Some(Err(TryRecvError::Disconnected)) => self.asked = None,
            Some(Err(TryRecvError::Empty)) | None => {}
        }
    }

    /// A controller on loopback calls nobody beyond it.
    fn may_call(&self, at: SocketAddr) -> bool {
        at.ip().is_loopback() || !self.address.is_loopback()
    }

    fn serve_requests(&mut self, controller: &mut Controller) {
        let (listener, clients) = &mut self.rtde;
        clients.extend(accepted(listener).map(|client| (client, Session::new(controller))));
        for (client, session) in clients.iter_mut() {
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
        self.rtde.1.retain(|(client, session)| {
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
        for (client, session) in &mut self.rtde.1 {
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
            let call = |at: SocketAddr| {
                let called = || TcpStream::connect_timeout(&at, CALL).and_then(Client::new).ok();
                self.may_call(at).then(called)?
            };
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
