//! A robot at the other end of a connection.

#![expect(clippy::disallowed_methods, reason = "the age of a frame is measured where it comes in")]

use std::io::{self, ErrorKind, Read};
use std::net::{IpAddr, Shutdown, SocketAddr, TcpListener, TcpStream};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use rustix::net::{SendFlags, send};

/// The most bytes that a frame of a robot may have.
pub const MAX_FRAME: usize = 4096;

/// Frames that wait to be read. A driver reads in every period; what comes while it does not is old.
const WAITING: usize = 16;

/// How long the receiving thread sleeps at most, which is how long a [`Line`] takes to end.
const NAP: Duration = Duration::from_millis(50);

/// How often a [`RobotListener`] looks whether the robot has come.
const KNOCK: Duration = Duration::from_millis(2);

/// Where the frame at the front of these bytes ends: how a protocol cuts its stream.
pub type Cut = fn(&[u8]) -> Cutting;

/// What a protocol says of the bytes that have come.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cutting {
    /// The frame at the front has so many bytes. More than [`MAX_FRAME`], or none, is no frame.
    Frame(usize),
    /// That is not known before more have come.
    More,
    /// They are no frame of this protocol: the line is closed.
    Bad,
}

/// A frame of the robot.
#[derive(Clone, Debug)]
pub struct Frame {
    came: Instant,
    len: usize,
    bytes: [u8; MAX_FRAME],
}

impl Frame {
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
}

/// What was not taken.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RefusedCounts {
    /// Connections of others than the robot.
    pub of_others: u64,
    /// Connections of the robot while another one was open.
    pub second: u64,
    /// Connections that were closed because what came was no frame.
    pub malformed: u64,
    /// Frames that came while older ones had not been read.
    pub unread: u64,
}

#[derive(Debug, Default)]
struct Counters {
    of_others: AtomicU64,
    second: AtomicU64,
    malformed: AtomicU64,
    unread: AtomicU64,
}

impl Counters {
    fn read(&self) -> RefusedCounts {
        let read = |counter: &AtomicU64| counter.load(Ordering::Relaxed);
        RefusedCounts {
            of_others: read(&self.of_others),
            second: read(&self.second),
            malformed: read(&self.malformed),
            unread: read(&self.unread),
        }
    }
}

fn count(counter: &AtomicU64) {
    counter.fetch_add(1, Ordering::Relaxed);
}

/// A connection with the robot. A thread of its own receives, so that reading never waits, and a frame's age does not depend
/// on when it is read. Sending does not wait either.
#[derive(Debug)]
pub struct Line {
    socket: TcpStream,
    waiting: rtrb::Consumer<Frame>,
    counters: Arc<Counters>,
    is_open: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Line {
    /// Calls the robot, for at most `timeout`.
    ///
    /// # Errors
    /// It does not answer, or refuses; or a thread cannot be started.
    pub fn call(robot: SocketAddr, timeout: Duration, cut: Cut) -> io::Result<Line> {
        Line::over(TcpStream::connect_timeout(&robot, timeout)?, cut, Arc::default())
    }

    fn over(socket: TcpStream, cut: Cut, counters: Arc<Counters>) -> io::Result<Line> {
        socket.set_nonblocking(false)?;
        socket.set_nodelay(true)?;
        socket.set_read_timeout(Some(NAP))?;
        let (sender, waiting) = rtrb::RingBuffer::new(WAITING);
        let is_open = Arc::new(AtomicBool::new(true));
        let (receiving, open, counts) = (socket.try_clone()?, Arc::clone(&is_open), Arc::clone(&counters));
        let thread = std::thread::Builder::new()
            .name("receive".to_owned())
            .spawn(move || receive(receiving, cut, sender, &open, &counts))?;
        Ok(Line { socket, waiting, counters, is_open, thread: Some(thread) })
    }

    /// The oldest frame that has not been read.
    pub fn oldest(&mut self) -> Option<Frame> {
        self.waiting.pop().ok()
    }

    /// This machine's address in the connection to the robot.
    ///
    /// # Errors
    /// The line is closed.
    pub fn own_address(&self) -> io::Result<IpAddr> {
        self.socket.local_addr().map(|address| address.ip())
    }

    /// Whether the robot may still say something.
    #[must_use]
    pub fn is_open(&self) -> bool {
        self.is_open.load(Ordering::Acquire)
    }

    /// Sends all of `bytes`, or closes the line: what the robot's end does not take at once is too late.
    ///
    /// # Errors
    /// The line is closed.
    pub fn send(&self, bytes: &[u8]) -> io::Result<()> {
        let sent = send(&self.socket, bytes, SendFlags::DONTWAIT | SendFlags::NOSIGNAL);
        match sent {
            Ok(sent) if sent == bytes.len() && self.is_open() => Ok(()),
            Ok(_) => {
                self.hang_up();
                Err(ErrorKind::WouldBlock.into())
            }
            Err(why) => {
                self.hang_up();
                Err(why.into())
            }
        }
    }

    /// Closes the line.
    pub fn hang_up(&self) {
        self.is_open.store(false, Ordering::Release);
        // The other end may have closed it already.
        let _ = self.socket.shutdown(Shutdown::Both);
    }

    /// What was not taken so far.
    #[must_use]
    pub fn refused(&self) -> RefusedCounts {
        self.counters.read()
    }
}

impl Drop for Line {
    fn drop(&mut self) {
        self.hang_up();
        // A thread that panicked has nothing left to end.
        let _ = self.thread.take().map(JoinHandle::join);
    }
}

fn receive(
    mut socket: TcpStream,
    cut: Cut,
    mut sender: rtrb::Producer<Frame>,
    is_open: &AtomicBool,
    counters: &Counters,
) {
    let mut buffer = [0; 2 * MAX_FRAME];
    let mut filled = 0;
    while is_open.load(Ordering::Acquire) {
        match socket.read(&mut buffer[filled..]) {
            Ok(0) => break,
            Ok(more) => filled += more,
            // A nap that is over.
            Err(why) if matches!(why.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) => continue,
            Err(why) if why.kind() == ErrorKind::Interrupted => continue,
            Err(_) => break,
        }
        let came = Instant::now();
        let mut start = 0;
        let ended = loop {
            match cut(&buffer[start..filled]) {
                Cutting::Frame(len) if (1..=MAX_FRAME).contains(&len) => {
                    let Some(frame) = buffer[..filled].get(start..start + len) else { break Cutting::More };
                    let mut bytes = [0; MAX_FRAME];
                    bytes[..len].copy_from_slice(frame);
                    if sender.push(Frame { came, len, bytes }).is_err() {
                        count(&counters.unread);
                    }
                    start += len;
                }
                Cutting::More if filled - start < MAX_FRAME => break Cutting::More,
                Cutting::More | Cutting::Frame(_) | Cutting::Bad => break Cutting::Bad,
            }
        };
        if ended == Cutting::Bad {
            count(&counters.malformed);
            break;
        }
        buffer.copy_within(start..filled, 0);
        filled -= start;
    }
    is_open.store(false, Ordering::Release);
    let _ = socket.shutdown(Shutdown::Both);
}

/// Where a robot calls this machine: one address and port. It takes one connection at a time, of the robot alone: others
/// are closed before anything of them is read, and counted.
///
/// ```
/// use mrroc_driver_kit::{Cutting, RobotListener};
/// use std::io::Write;
///
/// let mut listener = RobotListener::open("127.0.0.1:0".parse()?, "127.0.0.1".parse()?, |_| Cutting::Frame(1))?;
/// let mut robot = std::net::TcpStream::connect(listener.address())?;
/// robot.write_all(b"!")?;
/// let mut line = loop {
///     if let Some(line) = listener.answer() {
///         break line;
///     }
/// };
/// let frame = loop {
///     if let Some(frame) = line.oldest() {
///         break frame;
///     }
/// };
/// assert_eq!(frame.bytes(), b"!");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct RobotListener {
    address: SocketAddr,
    come: rtrb::Consumer<Line>,
    counters: Arc<Counters>,
    ends: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl RobotListener {
    /// Listens on `address`, one address of this machine and a port, for the robot alone.
    ///
    /// # Errors
    /// The address is none of this machine, or its port is taken; or a thread cannot be started.
    pub fn open(address: SocketAddr, robot: IpAddr, cut: Cut) -> io::Result<RobotListener> {
        let listener = TcpListener::bind(address)?;
        listener.set_nonblocking(true)?;
        let address = listener.local_addr()?;
        let (sender, come) = rtrb::RingBuffer::new(1);
        let (counters, ends) = (Arc::<Counters>::default(), Arc::<AtomicBool>::default());
        let (counts, over) = (Arc::clone(&counters), Arc::clone(&ends));
        let thread = std::thread::Builder::new()
            .name("listener".to_owned())
            .spawn(move || admit(&listener, robot, cut, sender, &counts, &over))?;
        Ok(RobotListener { address, come, counters, ends, thread: Some(thread) })
    }

    /// Where it listens: the port that was found, where 0 was asked for.
    #[must_use]
    pub fn address(&self) -> SocketAddr {
        self.address
    }

    /// The robot's connection, if it has come.
    pub fn answer(&mut self) -> Option<Line> {
        self.come.pop().ok()
    }

    /// What was not taken so far, on its lines too.
    #[must_use]
    pub fn refused(&self) -> RefusedCounts {
        self.counters.read()
    }
}

impl Drop for RobotListener {
    fn drop(&mut self) {
        self.ends.store(true, Ordering::Release);
        // A thread that panicked has nothing left to end.
        let _ = self.thread.take().map(JoinHandle::join);
    }
}

fn admit(
    listener: &TcpListener,
    robot: IpAddr,
    cut: Cut,
    mut sender: rtrb::Producer<Line>,
    counters: &Arc<Counters>,
    ends: &AtomicBool,
) {
    let mut open: Option<Arc<AtomicBool>> = None;
    while !ends.load(Ordering::Acquire) {
        // Nobody has come, or left again at once.
        let Ok((socket, from)) = listener.accept() else {
            std::thread::sleep(KNOCK);
            continue;
        };
        if from.ip() != robot {
            count(&counters.of_others);
            continue;
        }
        if open.as_ref().is_some_and(|open| open.load(Ordering::Acquire)) {
            count(&counters.second);
            continue;
        }
        // A line that nobody has asked for since is closed when it is let go.
        if let Ok(line) = Line::over(socket, cut, Arc::clone(counters)) {
            open = Some(Arc::clone(&line.is_open));
            drop(sender.push(line));
        }
    }
}

#[cfg(test)]
mod tests {
    use std::io::Write;

    use super::*;

    fn until<T>(mut look: impl FnMut() -> Option<T>) -> T {
        loop {
            if let Some(found) = look() {
                return found;
            }
            std::thread::sleep(Duration::from_millis(1));
        }
    }

    /// A byte with the length of the frame, which 0 is not.
    fn cut(bytes: &[u8]) -> Cutting {
        match bytes.first() {
            None => Cutting::More,
            Some(0) => Cutting::Bad,
            Some(len) => Cutting::Frame(usize::from(*len)),
        }
    }

    fn listener() -> RobotListener {
        RobotListener::open(
            "127.0.0.1:0".parse().expect("an address"),
            "127.0.0.1".parse().expect("one"),
            cut,
        )
        .expect("it listens")
    }

    #[test]
    fn frames_are_cut_from_the_stream_however_they_come() {
        let mut listener = listener();
        let mut robot = TcpStream::connect(listener.address()).expect("connected");
        let mut line = until(|| listener.answer());
        for byte in [3, 1, 2, 1, 2, 9, 1] {
            robot.write_all(&[byte]).expect("sent");
            robot.flush().expect("sent");
        }
        for frame in [&[3, 1, 2][..], &[1], &[2, 9], &[1]] {
            assert_eq!(until(|| line.oldest()).bytes(), frame);
        }
        line.send(b"go on").expect("sent");
        let mut answer = [0; 5];
        robot.read_exact(&mut answer).expect("received");
        assert_eq!(&answer, b"go on");
        // No frame begins with 0.
        robot.write_all(&[0, 7]).expect("sent");
        until(|| (!line.is_open()).then_some(()));
        assert_eq!(line.refused(), RefusedCounts { malformed: 1, ..RefusedCounts::default() });
        assert!(line.send(b"more").is_err());
    }

    #[test]
    fn one_connection_of_the_robot_is_taken_and_none_of_others() {
        let mut listener = listener();
        // It comes from the address that it calls.
        let others = RobotListener::open(
            "127.0.0.1:0".parse().expect("an address"),
            "127.0.0.2".parse().expect("one"),
            cut,
        );
        let mut others = others.expect("it listens");
        let mut stranger = TcpStream::connect(others.address()).expect("connected");
        until(|| (others.refused().of_others == 1).then_some(()));
        assert_eq!(stranger.read(&mut [0]).unwrap_or(0), 0, "it is closed");
        assert!(others.answer().is_none());

        let first = TcpStream::connect(listener.address()).expect("connected");
        let line = until(|| listener.answer());
        let _second = TcpStream::connect(listener.address()).expect("connected");
        until(|| (listener.refused().second == 1).then_some(()));
        assert!(listener.answer().is_none() && line.is_open());
        drop(first);
        until(|| (!line.is_open()).then_some(()));
        let _third = TcpStream::connect(listener.address()).expect("connected");
        assert!(until(|| listener.answer()).is_open());
    }

    #[test]
    fn what_the_other_end_does_not_take_closes_the_line_and_is_not_waited_for() {
        let mut listener = listener();
        let _robot = TcpStream::connect(listener.address()).expect("connected");
        let line = until(|| listener.answer());
        let lost = (0..100_000).find(|_| line.send(&[7; 4096]).is_err());
        assert!(lost.is_some_and(|full| full > 0) && !line.is_open());
    }

    #[test]
    fn a_robot_that_is_not_there_is_an_error() {
        let free = TcpListener::bind("127.0.0.1:0").and_then(|free| free.local_addr()).expect("a port");
        assert!(Line::call(free, Duration::from_millis(100), cut).is_err());
    }
}
