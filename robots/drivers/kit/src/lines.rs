//! Lines of text that a sensor or a device sends, over TCP or a serial line, for as long as the cell runs.
//!
//! In: where it is, and what it must be asked for. Out: the lines that have come, one by one and without waiting. A connection that is
//! closed, or silent for too long, is made again.

use core::fmt;
use core::time::Duration;
use std::collections::VecDeque;
use std::net::SocketAddr;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use crate::protocol::{NotConnected, Peer, Protocol, Received};
use crate::serial::Serial;
use crate::session::{Network, Session};

/// The longest line \[bytes\]; what is longer is no line of a device, and is left out.
const LONGEST: usize = 1024;

/// So many lines wait to be read at most; of more, the oldest are dropped.
const KEPT: usize = 1024;

/// How long a device may take to accept a connection, and how long after one has ended the next one is tried.
const TIMEOUT: Duration = Duration::from_secs(2);
const AGAIN: Duration = Duration::from_secs(1);

/// Where a device is.
#[derive(Clone, Debug, PartialEq, Eq)]
enum Place {
    Tcp(SocketAddr),
    Serial(Serial),
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Place::Tcp(address) => write!(f, "tcp {address}"),
            Place::Serial(Serial { path, .. }) => write!(f, "serial {}", path.display()),
        }
    }
}

/// Why no lines come.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NoLines {
    /// They have not been asked for: [`open`](Lines::open) has not been called.
    NotOpen,
    /// Nobody accepts a connection, or the serial line cannot be opened.
    Unreachable,
    /// The device has closed the connection.
    Closed,
    /// It has sent no line for too long.
    Silent,
    /// This program has closed it.
    HungUp,
    /// This machine has no thread for it.
    NoThread,
}

impl fmt::Display for NoLines {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            NoLines::NotOpen => "it is not open",
            NoLines::Unreachable => "it cannot be reached",
            NoLines::Closed => "it has closed the connection",
            NoLines::Silent => "it sends no line",
            NoLines::HungUp => "it is closed",
            NoLines::NoThread => "this machine has no thread for it",
        })
    }
}

/// What the thread has heard.
#[derive(Debug, Default)]
struct Heard {
    lines: VecDeque<String>,
    is_connected: bool,
}

/// The lines of a device, such as a bar-code scanner, a laser or a scale.
///
/// A thread of its own receives them, so that [`next_line`](Self::next_line) never waits. Where a connection ends, the next one is tried a
/// second later, again and again, as long as lines are asked for. A line ends with a line feed; carriage returns before it are left out, and so
/// is what is no UTF-8 or longer than 1024 bytes.
///
/// ```
/// use core::time::Duration;
/// use std::io::Write;
/// use mrroc_driver_kit::Lines;
///
/// let scale = std::net::TcpListener::bind("127.0.0.1:0")?;
/// let mut lines = Lines::over_tcp(scale.local_addr()?).silent_after(Duration::from_secs(5));
/// lines.open()?;
/// let (mut socket, _) = scale.accept()?;
/// socket.write_all(b"1.250 kg\r\n1.2")?;
/// let line = loop {
///     if let Some(line) = lines.next_line() {
///         break line;
///     }
/// };
/// assert_eq!(line, "1.250 kg");
/// # Ok::<(), std::io::Error>(())
/// ```
#[derive(Debug)]
pub struct Lines {
    place: Place,
    network: Network,
    ask: Option<(Duration, String)>,
    silence: Option<Duration>,
    heard: Arc<Mutex<Heard>>,
    session: Option<Session<NoLines>>,
    /// Why the last session is over, and when another one is tried, by its clock.
    over: Option<(NoLines, Duration)>,
}

impl Lines {
    fn of(place: Place) -> Lines {
        Lines {
            place,
            network: Network::SOCKETS,
            ask: None,
            silence: None,
            heard: Arc::default(),
            session: None,
            over: None,
        }
    }

    /// Of a device that listens at this address.
    #[must_use]
    pub fn over_tcp(address: SocketAddr) -> Lines {
        Lines::of(Place::Tcp(address))
    }

    /// Of a device at a serial line, such as `/dev/ttyUSB0`, at so many baud: 8 bits, no parity, one stop bit.
    #[must_use]
    pub fn over_serial(path: impl Into<PathBuf>, baud: u32) -> Lines {
        Lines::of(Place::Serial(Serial { path: path.into(), baud }))
    }

    /// Runs them over another network: in tests over a virtual one.
    #[must_use]
    pub fn over(self, network: Network) -> Lines {
        Lines { network, ..self }
    }

    /// Asks the device again and again, after each `period`: for a measurement, or whether it is alive. `line` is sent with a line feed
    /// behind it.
    #[must_use]
    pub fn asked_every(self, period: Duration, line: &str) -> Lines {
        Lines { ask: Some((period, format!("{line}\n"))), ..self }
    }

    /// A device that has sent no line for so long is connected anew: its cable was pulled, or it hangs. By default it may be silent.
    #[must_use]
    pub fn silent_after(self, silence: Duration) -> Lines {
        Lines { silence: Some(silence), ..self }
    }

    fn heard(&self) -> MutexGuard<'_, Heard> {
        self.heard.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Connects to the device, and waits until that is done: two seconds at most.
    ///
    /// # Errors
    /// Where nobody is, or why a serial line cannot be opened. It is tried again whenever lines are asked for.
    pub fn open(&mut self) -> std::io::Result<()> {
        let failed = |place: &Place, why: &dyn fmt::Display| {
            std::io::Error::new(std::io::ErrorKind::NotConnected, format!("{place}: {why}"))
        };
        let refused = match &self.place {
            Place::Serial(port) => port.open().err(),
            Place::Tcp(_) => None,
        };
        // A session that finds nobody is over, after which the next one is tried.
        self.begin();
        if let Some(why) = refused {
            return Err(failed(&self.place, &why));
        }
        loop {
            if self.heard().is_connected {
                return Ok(());
            }
            match self.session.as_ref().map_or(Err(NoLines::NoThread), Session::goes_on) {
                Ok(()) => self.network.wait(Duration::from_millis(1)),
                Err(why) => return Err(failed(&self.place, &why)),
            }
        }
    }

    fn begin(&mut self) {
        *self.heard() = Heard::default();
        let protocol = TextLines {
            heard: Arc::clone(&self.heard),
            begun: Vec::new(),
            is_too_long: false,
            ask: self.ask.clone(),
            asks_at: Duration::ZERO,
            silence: self.silence,
            last: None,
        };
        let session = match &self.place {
            Place::Tcp(address) => {
                let peer = Peer { address: *address, timeout: TIMEOUT, sends_datagrams: false };
                Session::begin(&self.network, "lines", peer, protocol, NoLines::HungUp)
            }
            Place::Serial(port) => Session::begin_serial("lines", port.clone(), protocol, NoLines::HungUp),
        };
        self.session = session.ok();
        self.over = self.session.is_none().then_some((NoLines::NoThread, Duration::ZERO));
    }

    /// Whether the device is connected and speaks.
    ///
    /// # Errors
    /// Why it does not.
    pub fn state(&self) -> Result<(), NoLines> {
        match &self.session {
            None => Err(self.over.map_or(NoLines::NotOpen, |(why, _)| why)),
            Some(session) => session.goes_on(),
        }
    }

    /// The next line that has come, without its end; `None` where none has. It never waits, and connects again where that is due.
    pub fn next_line(&mut self) -> Option<String> {
        if let Some(Err(why)) = self.session.as_ref().map(Session::goes_on) {
            let now = self.session.as_ref().map_or(Duration::ZERO, Session::now);
            let (_, at) = *self.over.get_or_insert((why, now + AGAIN));
            // What came before it ended is read first.
            if now >= at && self.heard().lines.is_empty() {
                self.begin();
            }
        } else if self.session.is_none() && self.over.is_some() {
            self.begin();
        }
        self.heard().lines.pop_front()
    }
}

impl fmt::Display for Lines {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.place.fmt(f)
    }
}

/// The protocol: lines, and what is asked for.
struct TextLines {
    heard: Arc<Mutex<Heard>>,
    /// A line that is not whole yet.
    begun: Vec<u8>,
    /// Whether the rest of it is left out, up to its end.
    is_too_long: bool,
    ask: Option<(Duration, String)>,
    asks_at: Duration,
    silence: Option<Duration>,
    /// When the last line came, or the connection was made.
    last: Option<Duration>,
}

impl TextLines {
    /// Takes bytes in; whether a line has become whole.
    fn take(&mut self, bytes: &[u8], heard: &mut Heard) -> bool {
        let mut is_whole = false;
        for &byte in bytes {
            if byte != b'\n' {
                self.is_too_long |= self.begun.len() >= LONGEST;
                if !self.is_too_long {
                    self.begun.push(byte);
                }
                continue;
            }
            let line = core::mem::take(&mut self.begun);
            if core::mem::take(&mut self.is_too_long) {
                continue;
            }
            if let Ok(line) = String::from_utf8(line) {
                if heard.lines.len() >= KEPT {
                    heard.lines.pop_front();
                }
                heard.lines.push_back(line.trim_end_matches('\r').to_owned());
                is_whole = true;
            }
        }
        is_whole
    }
}

impl Protocol for TextLines {
    type Fault = NoLines;

    fn poll(
        &mut self,
        now: Duration,
        received: Received<'_>,
        send: &mut Vec<u8>,
    ) -> Result<Duration, NoLines> {
        let shared = Arc::clone(&self.heard);
        let mut heard = shared.lock().unwrap_or_else(PoisonError::into_inner);
        heard.is_connected = true;
        let is_heard = self.take(received.bytes, &mut heard);
        drop(heard);
        let last = if is_heard { now } else { self.last.unwrap_or(now) };
        self.last = Some(last);
        if received.is_closed {
            return Err(NoLines::Closed);
        }
        let silent_at = self.silence.map(|silence| last + silence);
        if silent_at.is_some_and(|at| now >= at) {
            return Err(NoLines::Silent);
        }
        let mut next = silent_at.unwrap_or(Duration::MAX);
        if let Some((period, line)) = &self.ask {
            if now >= self.asks_at {
                send.extend_from_slice(line.as_bytes());
                self.asks_at = now + *period;
            }
            next = next.min(self.asks_at);
        }
        Ok(next)
    }

    fn not_connected(&self, _: NotConnected) -> NoLines {
        NoLines::Unreachable
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{Device, Faults, Reply, VirtualNetwork};

    const fn ms(time: u64) -> Duration {
        Duration::from_millis(time)
    }

    /// A device that sends what it is told to, counts its connections, and keeps what it was asked.
    #[derive(Default)]
    struct Scale {
        sends: Vec<u8>,
        closes: bool,
        connections: usize,
        asked: String,
        /// What it answers each question with.
        answer: &'static str,
    }

    impl Device for Scale {
        fn connected(&mut self) {
            self.connections += 1;
        }

        fn poll(&mut self, now: Duration, received: &[u8], reply: &mut Reply) -> Duration {
            self.asked += &String::from_utf8_lossy(received);
            reply.bytes = core::mem::take(&mut self.sends);
            if !received.is_empty() {
                reply.bytes.extend(self.answer.bytes());
            }
            reply.closes = core::mem::take(&mut self.closes);
            now + ms(1)
        }
    }

    struct Fixture {
        scale: Arc<Mutex<Scale>>,
        network: VirtualNetwork,
        lines: Lines,
    }

    fn fixture(with: impl FnOnce(Lines) -> Lines) -> Fixture {
        let scale = Arc::new(Mutex::new(Scale::default()));
        let network = VirtualNetwork::with(Arc::clone(&scale));
        let lines = with(Lines::over_tcp(([127, 0, 0, 1], 5000).into())).over(network.network());
        let mut all = Fixture { scale, network, lines };
        all.lines.open().expect("it is there");
        all
    }

    impl Fixture {
        fn scale(&self) -> MutexGuard<'_, Scale> {
            self.scale.lock().expect("whole")
        }

        fn send(&mut self, bytes: &[u8]) {
            self.scale().sends.extend(bytes);
            self.network.advance(ms(5));
        }

        /// The lines of some time, asked for each millisecond.
        fn lines(&mut self, time: u64) -> Vec<String> {
            let mut all = Vec::new();
            for _ in 0..time {
                self.network.advance(ms(1));
                all.extend(core::iter::from_fn(|| self.lines.next_line()));
            }
            all
        }
    }

    #[test]
    fn lines_come_whole_and_rubbish_between_them_is_left_out() {
        let mut all = fixture(|lines| lines);
        all.network.change(|now| *now = Faults { piece: 3, gap: ms(1), ..Faults::NONE });
        let long = vec![b'x'; 5000];
        all.send(b"1.25 kg\r\n\xff\xfe\n\nnine\n0.5");
        all.send(&[&long[..], b"\n2\n"].concat());
        let lines = all.lines(3000);
        assert_eq!(
            lines,
            ["1.25 kg", "", "nine", "2"],
            "what goes on for too long takes its beginning with it"
        );
    }

    #[test]
    fn a_device_that_closes_its_connection_or_is_silent_is_connected_again() {
        let mut all = fixture(|lines| lines.silent_after(ms(500)));
        all.send(b"one\n");
        all.scale().closes = true;
        assert_eq!(all.lines(10), ["one"]);
        assert_eq!(all.lines.state(), Err(NoLines::Closed));
        // A second later another connection stands.
        assert_eq!((all.lines(900), all.scale().connections), (vec![], 1));
        assert_eq!((all.lines(200), all.scale().connections), (vec![], 2));
        assert_eq!(all.lines.state(), Ok(()));
        all.send(b"two\n");
        assert_eq!(all.lines(10), ["two"]);
        // It hangs, and comes back.
        assert_eq!(all.lines(600), Vec::<String>::new());
        assert_eq!(all.lines.state(), Err(NoLines::Silent));
        let _ = all.lines(1000);
        assert_eq!((all.scale().connections, all.lines.state()), (3, Ok(())));
    }

    #[test]
    fn a_device_is_asked_again_and_again_and_its_answers_keep_it_connected() {
        let mut all = fixture(|lines| lines.asked_every(ms(100), "W?").silent_after(ms(350)));
        all.scale().answer = "3.5\n";
        assert_eq!(all.lines(1005).len(), 11 - 1);
        assert!((10..=11).contains(&all.scale().asked.matches("W?\n").count()), "{}", all.scale().asked);
        assert_eq!((all.scale().connections, all.lines.state()), (1, Ok(())));
    }

    #[test]
    fn where_nobody_is_the_address_is_named() {
        let mut lines =
            Lines::over_tcp(([127, 0, 0, 1], 5000).into()).over(VirtualNetwork::empty().network());
        assert_eq!(lines.state(), Err(NoLines::NotOpen));
        let why = lines.open().expect_err("nobody is there").to_string();
        assert_eq!(why, "tcp 127.0.0.1:5000: it cannot be reached");
        assert_eq!((lines.next_line(), lines.state()), (None, Err(NoLines::Unreachable)));
        let why = Lines::over_serial("/dev/mrroc-none", 9600).open().expect_err("no such device").to_string();
        assert!(why.starts_with("serial /dev/mrroc-none: ") && why.contains("No such file"), "{why}");
    }

    #[test]
    fn a_flood_of_lines_is_bounded() {
        let mut all = fixture(|lines| lines);
        let flood: String = (0..KEPT + 500).map(|n| format!("{n}\n")).collect();
        all.send(flood.as_bytes());
        all.network.advance(ms(100));
        let lines: Vec<_> = core::iter::from_fn(|| all.lines.next_line()).collect();
        assert_eq!((lines.len(), lines[0].as_str()), (KEPT, "500"), "the newest");
    }
}
