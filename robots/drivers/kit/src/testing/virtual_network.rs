//! A device and its sessions on one thread, under a virtual clock.
//!
//! Time passes only by [`VirtualNetwork::advance`]. Whatever is due is done in the order of its time; at one time the device comes
//! before the sessions. So a test sees the same in every run, and when it happened to the nanosecond.

use core::time::Duration;
use std::collections::VecDeque;
use std::fmt;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use super::device::{Device, Reply};
use crate::protocol::{NotConnected, Peer, Received};
use crate::task::{Running, Task};

/// Polls at one time after which nothing is expected to end it.
const POLLS: usize = 100_000;

/// A port for datagrams, as a session has one.
const PORT: u16 = 50_000;

/// What happens to messages between the two ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Faults {
    /// How long everything takes to arrive, in either direction.
    pub latency: Duration,
    /// How many bytes arrive together at most. By default all that have come by then, however many times they were sent at.
    pub piece: usize,
    /// How long the rest of them waits for its turn.
    pub gap: Duration,
    /// The byte of the device that is lost, counted from the next one that it sends.
    pub lost: Option<usize>,
    /// Nothing that the device sends from now on arrives, and nothing says so.
    pub is_silent: bool,
}

impl Faults {
    /// A network that takes no time.
    pub const NONE: Faults = Faults {
        latency: Duration::ZERO,
        piece: usize::MAX,
        gap: Duration::ZERO,
        lost: None,
        is_silent: false,
    };
}

/// Bytes in transit, each with the time of its arrival.
#[derive(Debug, Default)]
struct Stream(VecDeque<(Duration, u8)>);

impl Stream {
    fn next(&self) -> Duration {
        self.0.front().map_or(Duration::MAX, |(at, _)| *at)
    }

    fn send(&mut self, at: Duration, bytes: &[u8]) {
        // Nothing overtakes what was sent before.
        let at = self.0.back().map_or(at, |(last, _)| at.max(*last));
        self.0.extend(bytes.iter().map(|byte| (at, *byte)));
    }

    /// What has arrived by now, in a piece; the rest arrives after a gap.
    fn arrive(&mut self, now: Duration, faults: &Faults) -> Vec<u8> {
        let due = self.0.iter().take_while(|(at, _)| *at <= now).count().min(faults.piece);
        let bytes = self.0.drain(..due).map(|(_, byte)| byte).collect();
        for (at, _) in self.0.iter_mut().take_while(|(at, _)| *at < now + faults.gap) {
            *at = now + faults.gap;
        }
        bytes
    }
}

struct Connection {
    task: Box<dyn Task>,
    began: Duration,
    /// When the session is to be polled.
    next: Duration,
    port: u16,
    to_device: Stream,
    to_session: Stream,
    datagrams: VecDeque<(Duration, Vec<u8>)>,
    /// When the session hears that it is closed, and whether it has.
    closes: Duration,
    is_closed: bool,
    is_over: Arc<AtomicBool>,
}

impl Connection {
    fn is_over(&self) -> bool {
        self.is_over.load(Ordering::Acquire)
    }

    fn next(&self) -> Duration {
        if self.is_over() {
            return Duration::MAX;
        }
        let closes = if self.is_closed { Duration::MAX } else { self.closes };
        self.next.min(self.to_session.next()).min(closes)
    }

    fn poll(&mut self, now: Duration, faults: &Faults) {
        let bytes = self.to_session.arrive(now, faults);
        // Bytes that were sent before the end come before it.
        self.is_closed |= self.closes <= now && self.to_session.0.is_empty();
        let mut datagram = None;
        while self.datagrams.front().is_some_and(|(at, _)| *at <= now) {
            datagram = self.datagrams.pop_front().map(|(_, bytes)| bytes);
        }
        let (port, is_closed) = (self.port, self.is_closed);
        let received = Received { bytes: &bytes, datagram: datagram.as_deref(), is_closed, port };
        let mut send = Vec::new();
        let next = self.task.poll(now - self.began, received, &mut send);
        if !is_closed {
            self.to_device.send(now + faults.latency, &send);
        }
        match next {
            Some(next) => self.next = next.saturating_add(self.began),
            None => self.is_over.store(true, Ordering::Release),
        }
    }
}

struct World {
    now: Duration,
    device: Option<Arc<Mutex<dyn Device>>>,
    /// When the device is to be polled.
    next: Duration,
    faults: Faults,
    /// The device hears the newest one. One that is over stays until what it has sent has arrived.
    connections: Vec<Connection>,
}

impl World {
    fn next(&self) -> Duration {
        let of = |connection: &Connection| connection.next().min(connection.to_device.next());
        self.connections.iter().map(of).min().unwrap_or(Duration::MAX).min(self.next)
    }

    fn advance(&mut self, time: Duration) {
        let until = self.now + time;
        let (mut polls, mut at) = (0, self.now);
        while self.next() <= until {
            self.now = self.now.max(self.next());
            (polls, at) = if at == self.now { (polls + 1, at) } else { (0, self.now) };
            assert!(polls < POLLS, "{POLLS} polls at one time, {at:?}: neither end waits for anything");
            self.poll_device();
            for connection in &mut self.connections {
                if connection.next() <= self.now {
                    connection.poll(self.now, &self.faults);
                }
            }
            self.connections.retain(|connection| !connection.is_over() || !connection.to_device.0.is_empty());
        }
        self.now = until;
    }

    fn poll_device(&mut self) {
        let (now, faults) = (self.now, self.faults);
        let Some(device) = &self.device else { return };
        let mut bytes = Vec::new();
        for connection in &mut self.connections {
            bytes.extend(connection.to_device.arrive(now, &faults));
        }
        if bytes.is_empty() && self.next > now {
            return;
        }
        let mut reply = Reply::default();
        self.next = device.lock().unwrap_or_else(PoisonError::into_inner).poll(now, &bytes, &mut reply);
        let Some(connection) = self.connections.last_mut().filter(|connection| !connection.is_over()) else {
            return;
        };
        let at = now + faults.latency;
        if !faults.is_silent {
            let sent = reply.bytes.len();
            if let Some(lost) = faults.lost {
                if lost < sent {
                    reply.bytes.remove(lost);
                }
                self.faults.lost = lost.checked_sub(sent);
            }
            connection.to_session.send(at, &reply.bytes);
            let own = reply.datagrams.into_iter().filter(|(port, _)| *port == connection.port);
            connection.datagrams.extend(own.map(|(_, bytes)| (at, bytes)));
        }
        if reply.closes {
            connection.closes = connection.closes.min(at);
        }
    }
}

/// A device, its sessions, and the virtual clock of both.
#[derive(Clone)]
pub struct VirtualNetwork(Arc<Mutex<World>>);

impl fmt::Debug for VirtualNetwork {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("VirtualNetwork")
    }
}

impl VirtualNetwork {
    /// With this device at whatever address is connected.
    #[must_use]
    pub fn with<D: Device>(device: Arc<Mutex<D>>) -> VirtualNetwork {
        VirtualNetwork::new(Some(device))
    }

    /// With nobody who accepts a connection.
    #[must_use]
    pub fn empty() -> VirtualNetwork {
        VirtualNetwork::new(None)
    }

    fn new(device: Option<Arc<Mutex<dyn Device>>>) -> VirtualNetwork {
        let next = if device.is_some() { Duration::ZERO } else { Duration::MAX };
        let (now, faults, connections) = (Duration::ZERO, Faults::NONE, Vec::new());
        VirtualNetwork(Arc::new(Mutex::new(World { now, device, next, faults, connections })))
    }

    fn world(&self) -> MutexGuard<'_, World> {
        // A model that panics ends its test.
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The time since its beginning.
    #[must_use]
    pub fn now(&self) -> Duration {
        self.world().now
    }

    /// So much time passes, and whatever is due by then is done.
    pub fn advance(&self, time: Duration) {
        self.world().advance(time);
    }

    /// Changes what happens to messages, from now on.
    pub fn change(&self, change: impl FnOnce(&mut Faults)) {
        change(&mut self.world().faults);
    }

    /// The newest connection is closed by the device's end, without its device.
    pub fn close(&self) {
        let mut world = self.world();
        let at = world.now + world.faults.latency;
        if let Some(connection) = world.connections.last_mut() {
            connection.closes = connection.closes.min(at);
        }
    }

    /// Looks in steps of 1 ms until something is found.
    ///
    /// # Panics
    /// It is not found within 60 s.
    pub fn until<T>(&self, mut look: impl FnMut() -> Option<T>) -> T {
        let limit = self.now() + Duration::from_secs(60);
        loop {
            if let Some(found) = look() {
                return found;
            }
            assert!(self.now() < limit, "it has not happened by {limit:?}");
            self.advance(Duration::from_millis(1));
        }
    }

    pub(crate) fn connect(&self, peer: Peer, mut task: Box<dyn Task>) -> Attached {
        let mut world = self.world();
        let (began, is_over) = (world.now, Arc::new(AtomicBool::new(false)));
        let attached = Attached { network: self.clone(), began, is_over: Arc::clone(&is_over) };
        let Some(device) = &world.device else {
            task.fail(NotConnected::Unreachable);
            is_over.store(true, Ordering::Release);
            return attached;
        };
        device.lock().unwrap_or_else(PoisonError::into_inner).connected();
        let next = began + world.faults.latency * 2;
        world.connections.push(Connection {
            task,
            began,
            next,
            port: if peer.sends_datagrams { PORT } else { 0 },
            to_device: Stream::default(),
            to_session: Stream::default(),
            datagrams: VecDeque::new(),
            closes: Duration::MAX,
            is_closed: false,
            is_over,
        });
        attached
    }
}

/// A session of a virtual network.
#[derive(Debug)]
pub(crate) struct Attached {
    network: VirtualNetwork,
    began: Duration,
    is_over: Arc<AtomicBool>,
}

impl Running for Attached {
    fn now(&self) -> Duration {
        self.network.now() - self.began
    }

    fn hang_up(&self) {
        let mut world = self.network.world();
        for connection in &mut world.connections {
            if Arc::ptr_eq(&connection.is_over, &self.is_over) && !connection.is_over() {
                connection.task.close();
                connection.is_over.store(true, Ordering::Release);
            }
        }
    }

    fn is_over(&self) -> bool {
        self.is_over.load(Ordering::Acquire)
    }
}

impl Drop for Attached {
    fn drop(&mut self) {
        self.hang_up();
    }
}
