//! A robot that sends datagrams.

#![expect(clippy::disallowed_methods, reason = "the age of a datagram is measured where it comes in")]

use std::io;
use std::net::{IpAddr, SocketAddr, UdpSocket};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

/// The most bytes that a datagram of a robot may have: more would be split by the network.
pub const MAX_DATAGRAM: usize = 1472;

/// Datagrams that wait to be read. A driver reads in every period; what comes while it does not is old.
const WAITING: usize = 16;

/// How long the receiving thread sleeps at most, which is how long [`Guest`] takes to end.
const NAP: Duration = Duration::from_millis(50);

/// A datagram that would have waited for longer came before the clock was set.
const LONGEST: Duration = Duration::from_secs(1);

/// A datagram of the robot.
#[derive(Clone, Debug)]
pub struct Datagram {
    came: Instant,
    from: SocketAddr,
    len: usize,
    bytes: [u8; MAX_DATAGRAM],
}

impl Datagram {
    /// How long it has been here.
    #[must_use]
    pub fn age(&self) -> Duration {
        self.came.elapsed()
    }

    /// What it says.
    #[must_use]
    pub fn bytes(&self) -> &[u8] {
        &self.bytes[..self.len]
    }

    /// Who sent it: where the answer goes.
    #[must_use]
    pub fn from(&self) -> SocketAddr {
        self.from
    }

    /// The same by a clock that began then.
    #[must_use]
    pub fn by_clock(&self, began: Instant) -> Arrived<'_> {
        Arrived { bytes: self.bytes(), from: self.from, came: self.came.saturating_duration_since(began) }
    }
}

/// A datagram of the robot, by the clock of a driver's network: that of this machine, or a virtual one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Arrived<'a> {
    /// What it says.
    pub bytes: &'a [u8],
    /// Who sent it: where the answer goes.
    pub from: SocketAddr,
    /// When it came in, since the clock began.
    pub came: Duration,
}

/// What was not taken.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counted {
    /// Datagrams of others than the robot.
    pub of_others: u64,
    /// Datagrams of the robot with more than [`MAX_DATAGRAM`] bytes.
    pub too_long: u64,
    /// Datagrams of the robot that came while older ones had not been read.
    pub unread: u64,
}

#[derive(Default)]
struct Counters {
    of_others: AtomicU64,
    too_long: AtomicU64,
    unread: AtomicU64,
    ends: AtomicBool,
}

/// A robot that sends datagrams to an address of this machine. Datagrams of anybody else are counted and thrown away
/// before they are looked at. A thread of its own receives, so that reading never waits, and a datagram's age does not
/// depend on when it is read.
///
/// ```
/// use mrroc_driver_kit::Guest;
///
/// let robot = std::net::UdpSocket::bind("127.0.0.1:0")?;
/// let mut guest = Guest::expect("127.0.0.1:0".parse()?, robot.local_addr()?.ip())?;
/// robot.send_to(b"here I am", guest.address())?;
/// let datagram = loop {
///     if let Some(datagram) = guest.newest() {
///         break datagram;
///     }
/// };
/// assert_eq!(datagram.bytes(), b"here I am");
/// guest.answer(&datagram, b"go on")?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct Guest {
    socket: UdpSocket,
    address: SocketAddr,
    waiting: rtrb::Consumer<Datagram>,
    counters: Arc<Counters>,
    thread: Option<JoinHandle<()>>,
}

impl std::fmt::Debug for Counters {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{:?}", self.read())
    }
}

impl Counters {
    fn read(&self) -> Counted {
        Counted {
            of_others: self.of_others.load(Ordering::Relaxed),
            too_long: self.too_long.load(Ordering::Relaxed),
            unread: self.unread.load(Ordering::Relaxed),
        }
    }
}

impl Guest {
    /// Listens on `address`, one address of this machine and a port, for the robot alone.
    ///
    /// # Errors
    /// The address is none of this machine, or its port is taken; or a thread cannot be started.
    pub fn expect(address: SocketAddr, robot: IpAddr) -> io::Result<Guest> {
        let socket = UdpSocket::bind(address)?;
        let (sender, waiting) = rtrb::RingBuffer::new(WAITING);
        let counters = Arc::new(Counters::default());
        let receiving = socket.try_clone()?;
        receiving.set_read_timeout(Some(NAP))?;
        let counts = Arc::clone(&counters);
        let thread = std::thread::Builder::new()
            .name("receive".to_owned())
            .spawn(move || receive(&receiving, robot, sender, &counts))?;
        let address = socket.local_addr()?;
        Ok(Guest { socket, address, waiting, counters, thread: Some(thread) })
    }

    /// Where it listens: the port that was found, where 0 was asked for.
    #[must_use]
    pub fn address(&self) -> SocketAddr {
        self.address
    }

    /// The last datagram of the robot that has not been read. Older ones are thrown away.
    pub fn newest(&mut self) -> Option<Datagram> {
        let mut newest = None;
        while let Ok(datagram) = self.waiting.pop() {
            newest = Some(datagram);
        }
        newest
    }

    /// Sends an answer to who sent a datagram. It returns at once.
    ///
    /// # Errors
    /// The network takes nothing.
    pub fn answer(&self, to: &Datagram, bytes: &[u8]) -> io::Result<()> {
        self.send(to.from, bytes)
    }

    /// Sends an answer to this address, which is that of a datagram. It returns at once.
    ///
    /// # Errors
    /// The network takes nothing.
    pub fn send(&self, to: SocketAddr, bytes: &[u8]) -> io::Result<()> {
        self.socket.send_to(bytes, to).map(drop)
    }

    /// What was not taken so far.
    #[must_use]
    pub fn counted(&self) -> Counted {
        self.counters.read()
    }
}

impl Drop for Guest {
    fn drop(&mut self) {
        self.counters.ends.store(true, Ordering::Release);
        // A thread that panicked has nothing left to end.
        let _ = self.thread.take().map(JoinHandle::join);
    }
}

/// How long the datagram that was received last has waited for this thread, by the kernel, which notes when it came in. Zero where
/// it does not.
#[cfg(target_os = "linux")]
fn waited(socket: &UdpSocket) -> Duration {
    use std::os::fd::AsRawFd;

    /// `SIOCGSTAMPNS` of Linux, which turns the notes on when it is asked first.
    const STAMP: libc::Ioctl = 0x8907;
    let mut stamp = libc::timespec { tv_sec: 0, tv_nsec: 0 };
    // SAFETY: the socket is open, and this request writes one `timespec`.
    let noted = unsafe { libc::ioctl(socket.as_raw_fd(), STAMP, &raw mut stamp) } == 0;
    let came = Duration::new(stamp.tv_sec.max(0).cast_unsigned(), stamp.tv_nsec as u32);
    let now = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    // The clock may have been set in between.
    let waited = now.saturating_sub(came);
    if noted && waited <= LONGEST { waited } else { Duration::ZERO }
}

#[cfg(not(target_os = "linux"))]
fn waited(_: &UdpSocket) -> Duration {
    Duration::ZERO
}

fn receive(socket: &UdpSocket, robot: IpAddr, mut sender: rtrb::Producer<Datagram>, counters: &Counters) {
    // One byte more than may be, to see what is too long.
    let mut buffer = [0; MAX_DATAGRAM + 1];
    while !counters.ends.load(Ordering::Acquire) {
        // A nap that is over, or an answer that nobody took: the robot is not there yet.
        let Ok((len, from)) = socket.recv_from(&mut buffer) else { continue };
        let now = Instant::now();
        let came = now.checked_sub(waited(socket)).unwrap_or(now);
        let count = |counter: &AtomicU64| counter.fetch_add(1, Ordering::Relaxed);
        if from.ip() != robot {
            count(&counters.of_others);
        } else if len > MAX_DATAGRAM {
            count(&counters.too_long);
        } else {
            let mut bytes = [0; MAX_DATAGRAM];
            bytes[..len].copy_from_slice(&buffer[..len]);
            if sender.push(Datagram { came, from, len, bytes }).is_err() {
                count(&counters.unread);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn until<T>(mut look: impl FnMut() -> Option<T>) -> T {
        loop {
            if let Some(found) = look() {
                return found;
            }
            std::thread::sleep(Duration::from_millis(1));
        }
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn a_datagram_is_as_old_as_it_has_been_on_this_machine_and_not_in_this_program() {
        let robot = UdpSocket::bind("127.0.0.1:0").expect("a socket");
        let here = UdpSocket::bind("127.0.0.1:0").expect("a socket");
        let to = here.local_addr().expect("bound");
        let mut buffer = [0; 8];
        // The first time turns the kernel's notes on, which it does when it has time for it.
        for _ in 0..50 {
            let before = Instant::now();
            robot.send_to(b"here", to).expect("sent");
            std::thread::sleep(Duration::from_millis(20));
            here.recv_from(&mut buffer).expect("received");
            let waited = waited(&here);
            assert!(waited <= before.elapsed(), "{waited:?}");
            if waited >= Duration::from_millis(19) {
                return;
            }
        }
        panic!("the kernel notes no times");
    }

    #[test]
    fn the_newest_datagram_of_the_robot_is_read_and_those_of_others_are_counted() {
        let robot = UdpSocket::bind("127.0.0.1:0").expect("a socket");
        let stranger = UdpSocket::bind("127.0.0.2:0").expect("a socket");
        let ip = robot.local_addr().expect("bound").ip();
        let mut guest = Guest::expect("127.0.0.1:0".parse().expect("an address"), ip).expect("it listens");
        stranger.send_to(b"move", guest.address()).expect("sent");
        until(|| (guest.counted().of_others == 1).then_some(()));
        assert!(guest.newest().is_none());
        robot.send_to(&[7; MAX_DATAGRAM + 1], guest.address()).expect("sent");
        until(|| (guest.counted().too_long == 1).then_some(()));
        assert!(guest.newest().is_none());
        // More than wait at once: the rest is counted, and the last one that waits is the newest.
        for number in 0..WAITING as u8 + 3 {
            robot.send_to(&[number], guest.address()).expect("sent");
        }
        until(|| (guest.counted().unread == 3).then_some(()));
        let newest = guest.newest().expect("one");
        assert_eq!(newest.bytes(), [WAITING as u8 - 1]);
        assert!(guest.newest().is_none());
        guest.answer(&newest, b"yes").expect("sent");
        let mut answer = [0; 8];
        let (len, from) = robot.recv_from(&mut answer).expect("received");
        assert_eq!((&answer[..len], from), (&b"yes"[..], guest.address()));
    }
}
