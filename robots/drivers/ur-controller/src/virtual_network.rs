//! A controller with all of its interfaces in the process of its drivers, under a virtual clock.
//!
//! In: calls of drivers, and how much time passes. Out: what the controller answers and tells, as it does on sockets. Its periods go by
//! when a driver waits, or when a test lets time pass: nothing here takes real time, and all of it is the same each time.

use core::cell::RefCell;
use core::time::Duration;
use std::collections::VecDeque;
use std::io::{self, ErrorKind, Write};
use std::net::{IpAddr, Ipv4Addr, SocketAddr};
use std::rc::Rc;

use mrroc_driver_kit::{Cut, Cutting, MAX_FRAME, RefusedCounts};
use mrroc_ur::{Connection, Listener, Network, PERIOD, Ports, Received};

use crate::controller::Controller;
use crate::pipe::{Clock, Pipe, Status};
use crate::service::{self, Interface, Service};

/// The first port that is given where 0 is asked for.
const FIRST_PORT: u16 = 50001;

/// How an interface of the controller answers calls.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OnCall {
    /// It answers them and serves the caller.
    Serve,
    /// It refuses them: nobody is there.
    Refuse,
    /// It takes the connection, and says nothing.
    StaySilent,
}

/// What listens to calls of the controller.
#[derive(Debug)]
struct OpenPort {
    at: SocketAddr,
    waiting: VecDeque<Pipe>,
    /// The connection that it has, if it is open.
    one: Option<Status>,
    second: u64,
}

/// The connections that are not accepted yet.
#[derive(Debug)]
struct Pending {
    clock: Clock,
    on_call: [OnCall; 4],
    calls: [VecDeque<Pipe>; 4],
    listeners: Vec<OpenPort>,
    /// Ends to which nobody listens.
    kept: Vec<Pipe>,
    next_port: u16,
}

/// The controller, and what it serves.
struct Served {
    controller: Controller,
    service: Service<Interfaces>,
    next: Duration,
}

/// A network with one controller in it, and a clock. Its clones are the same network.
///
/// ```
/// use mrroc_robots::Six;
/// use mrroc_ur::{Connections, Ports, Ur, UrModel, UrSettings};
/// use mrroc_ur_controller::{Controller, VirtualNetwork};
///
/// let start = Six::new(0.0, -1.5, 1.5, -1.5, -1.5, 0.0);
/// let network = VirtualNetwork::new(Controller::new(UrModel::Ur5e, &start)?);
/// let settings = UrSettings::new(UrModel::Ur5e, VirtualNetwork::ROBOT, "127.0.0.1:50001".parse()?);
/// let wire = Connections::over(network.clone(), settings.robot, settings.listen, Ports::default());
/// let drives = Ur::over(wire, settings); // its clock is `network.now()`
/// # drop(drives);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone)]
pub struct VirtualNetwork {
    clock: Clock,
    pending: Rc<RefCell<Pending>>,
    served: Rc<RefCell<Served>>,
}

impl core::fmt::Debug for VirtualNetwork {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("VirtualNetwork").field("now", &self.clock.get()).finish_non_exhaustive()
    }
}

impl VirtualNetwork {
    /// The controller's address. Its ports are those of a robot.
    pub const ROBOT: IpAddr = IpAddr::V4(Ipv4Addr::LOCALHOST);

    /// A network with this controller, whose first period begins now, at 0.
    #[must_use]
    pub fn new(controller: Controller) -> VirtualNetwork {
        let clock = Clock::default();
        let pending = Rc::new(RefCell::new(Pending {
            clock: Rc::clone(&clock),
            on_call: [OnCall::Serve; 4],
            calls: Default::default(),
            listeners: Vec::new(),
            kept: Vec::new(),
            next_port: FIRST_PORT,
        }));
        let service = Service::new(Interfaces(Rc::clone(&pending)));
        let served = Rc::new(RefCell::new(Served { controller, service, next: Duration::ZERO }));
        VirtualNetwork { clock, pending, served }
    }

    /// Lets so much time pass.
    pub fn pass(&self, time: Duration) {
        let until = self.clock.get() + time;
        let mut served = self.served.borrow_mut();
        let Served { controller, service, next } = &mut *served;
        while *next <= until {
            self.clock.set(*next);
            service.period(controller, &mut |_| {});
            *next += PERIOD;
        }
        self.clock.set(until);
    }

    /// Looks at the controller between two periods, or presses something.
    pub fn with<T>(&self, look: impl FnOnce(&mut Controller) -> T) -> T {
        look(&mut self.served.borrow_mut().controller)
    }

    /// How an interface answers calls from now on.
    pub fn set(&self, interface: Interface, on_call: OnCall) {
        self.pending.borrow_mut().on_call[interface as usize] = on_call;
    }

    /// Closes all connections, as a controller does that is switched off; who calls again is answered.
    pub fn cut(&self) {
        self.served.borrow_mut().service = Service::new(Interfaces(Rc::clone(&self.pending)));
    }

    /// Calls this machine as the controller does: the other end's connection, where somebody listens at this address.
    #[must_use]
    pub fn call_from_robot(&self, to: SocketAddr) -> Option<Pipe> {
        self.pending.borrow_mut().call(to)
    }
}

impl Pending {
    /// Calls a listener, which takes one connection at a time.
    fn call(&mut self, to: SocketAddr) -> Option<Pipe> {
        let clock = Rc::clone(&self.clock);
        let port = self.listeners.iter_mut().find(|port| port.at == to)?;
        let [here, there] = Pipe::pair(&clock);
        if port.one.as_ref().is_some_and(Status::is_open) {
            port.second += 1;
        } else {
            port.one = Some(there.status());
            port.waiting.push_back(there);
        }
        Some(here)
    }
}

/// The controller's end of the network.
struct Interfaces(Rc<RefCell<Pending>>);

impl service::Network for Interfaces {
    type Stream = Pipe;

    fn accept(&mut self, interface: Interface) -> Option<Pipe> {
        self.0.borrow_mut().calls[interface as usize].pop_front()
    }

    fn call(&mut self, to: SocketAddr) -> Option<Pipe> {
        self.0.borrow_mut().call(to)
    }
}

/// A connection of a driver.
#[derive(Debug)]
pub struct VirtualConnection {
    pipe: Pipe,
    cut: Cut,
    frame: Vec<u8>,
}

impl Connection for VirtualConnection {
    fn oldest(&mut self) -> Option<Received<'_>> {
        let waiting = self.pipe.waiting();
        match (self.cut)(&waiting) {
            Cutting::Frame(len) if (1..=MAX_FRAME).contains(&len) => {
                if waiting.len() < len {
                    return None;
                }
                let (frame, came) = self.pipe.take_front(len);
                self.frame = frame;
                let age = self.pipe.now().saturating_sub(came);
                Some(Received { bytes: &self.frame, age })
            }
            Cutting::More if waiting.len() < MAX_FRAME => None,
            Cutting::More | Cutting::Frame(_) | Cutting::Bad => {
                self.pipe.close();
                None
            }
        }
    }

    fn is_open(&self) -> bool {
        self.pipe.is_open()
    }

    fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
        let sent = self.pipe.write(bytes);
        if !matches!(sent, Ok(sent) if sent == bytes.len()) {
            self.pipe.close();
        }
        if sent? == bytes.len() { Ok(()) } else { Err(ErrorKind::WouldBlock.into()) }
    }
}

/// A port at which the controller calls.
#[derive(Debug)]
pub struct VirtualPort {
    at: SocketAddr,
    cut: Cut,
    pending: Rc<RefCell<Pending>>,
}

impl Drop for VirtualPort {
    fn drop(&mut self) {
        self.pending.borrow_mut().listeners.retain(|port| port.at != self.at);
    }
}

impl Listener for VirtualPort {
    type Connection = VirtualConnection;

    fn address(&self) -> SocketAddr {
        self.at
    }

    fn accept(&mut self) -> Option<VirtualConnection> {
        let mut pending = self.pending.borrow_mut();
        let port = pending.listeners.iter_mut().find(|port| port.at == self.at)?;
        let pipe = port.waiting.pop_front()?;
        Some(VirtualConnection { pipe, cut: self.cut, frame: Vec::new() })
    }

    fn refused(&self) -> RefusedCounts {
        let pending = self.pending.borrow();
        let second = pending.listeners.iter().find(|port| port.at == self.at).map_or(0, |port| port.second);
        RefusedCounts { second, ..RefusedCounts::default() }
    }
}

impl Network for VirtualNetwork {
    type Connection = VirtualConnection;
    type Call = Option<io::Result<VirtualConnection>>;
    type Listener = VirtualPort;

    fn now(&self) -> Duration {
        self.clock.get()
    }

    fn call(&mut self, to: SocketAddr, _: Duration, cut: Cut) -> Self::Call {
        let Ports { dashboard, primary, secondary, rtde } = Ports::default();
        let interface = match to.port() {
            port if port == dashboard => Interface::Dashboard,
            port if port == primary => Interface::Primary,
            port if port == secondary => Interface::Secondary,
            port if port == rtde => Interface::Rtde,
            _ => return Some(Err(ErrorKind::ConnectionRefused.into())),
        };
        let mut pending = self.pending.borrow_mut();
        let [pipe, there] = Pipe::pair(&self.clock);
        match pending.on_call[interface as usize] {
            OnCall::Refuse => return Some(Err(ErrorKind::ConnectionRefused.into())),
            OnCall::StaySilent => pending.kept.push(there),
            OnCall::Serve => pending.calls[interface as usize].push_back(there),
        }
        Some(Ok(VirtualConnection { pipe, cut, frame: Vec::new() }))
    }

    fn called(&mut self, call: &mut Self::Call) -> Option<io::Result<VirtualConnection>> {
        call.take()
    }

    fn listen(&mut self, at: SocketAddr, _: IpAddr, cut: Cut) -> io::Result<VirtualPort> {
        let mut pending = self.pending.borrow_mut();
        let at = match at.port() {
            0 => {
                pending.next_port += 1;
                SocketAddr::new(at.ip(), pending.next_port - 1)
            }
            _ => at,
        };
        if pending.listeners.iter().any(|port| port.at == at) {
            return Err(ErrorKind::AddrInUse.into());
        }
        pending.listeners.push(OpenPort { at, waiting: VecDeque::new(), one: None, second: 0 });
        Ok(VirtualPort { at, cut, pending: Rc::clone(&self.pending) })
    }

    fn wait(&mut self, time: Duration) {
        self.pass(time);
    }
}
