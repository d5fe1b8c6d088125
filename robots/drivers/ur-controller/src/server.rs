//! The controller on sockets, in real time.
//!
//! In: connections of clients. Out: what the controller answers and tells. One thread serves all of them once in a period.

#![expect(clippy::disallowed_methods, reason = "it keeps real time")]

use std::io;
use std::net::{IpAddr, SocketAddr, TcpListener, TcpStream};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use mrroc_robots::Six;
use mrroc_ur::{PERIOD, Ports, UrModel};

use crate::controller::Controller;
use crate::service::{Interface, Network, Service};

/// How long whom the controller calls may take to answer.
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
        let listeners = Listeners { dashboards, primaries, secondaries, rtdes, address };
        let service = Service::new(listeners);
        let (looks, asked) = channel();
        let over = Arc::clone(&ends);
        let thread = std::thread::Builder::new().name("controller".to_owned()).spawn(move || {
            // The arms of all models are made: a test of `mrroc-ur` makes them.
            if let Ok(controller) = Controller::new(model, &start) {
                serve(service, controller, watch, &asked, &over);
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
fn serve(
    mut service: Service<Listeners>,
    mut controller: Controller,
    mut watch: Watch,
    asked: &Receiver<Look>,
    over: &AtomicBool,
) {
    let mut due = Instant::now();
    while !over.load(Ordering::Acquire) {
        service.period(&mut controller, &mut watch);
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

/// The sockets at which it is called.
struct Listeners {
    dashboards: TcpListener,
    primaries: TcpListener,
    secondaries: TcpListener,
    rtdes: TcpListener,
    address: IpAddr,
}

fn prepared(stream: TcpStream) -> io::Result<TcpStream> {
    stream.set_nonblocking(true)?;
    stream.set_nodelay(true)?;
    Ok(stream)
}

impl Network for Listeners {
    type Stream = TcpStream;

    fn accept(&mut self, interface: Interface) -> Option<TcpStream> {
        let listener = match interface {
            Interface::Dashboard => &self.dashboards,
            Interface::Primary => &self.primaries,
            Interface::Secondary => &self.secondaries,
            Interface::Rtde => &self.rtdes,
        };
        // One that has gone away meanwhile is passed over.
        core::iter::from_fn(|| listener.accept().ok()).find_map(|(stream, _)| prepared(stream).ok())
    }

    fn call(&mut self, to: SocketAddr) -> Option<TcpStream> {
        // A controller on loopback calls nobody beyond it.
        let may_call = to.ip().is_loopback() || !self.address.is_loopback();
        let called = || TcpStream::connect_timeout(&to, CALL).and_then(prepared).ok();
        may_call.then(called)?
    }
}
