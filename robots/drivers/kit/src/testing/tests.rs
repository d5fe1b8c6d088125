//! What the virtual network does to messages, seen by a protocol that notes when it is polled with what.

use core::time::Duration;
use std::sync::{Arc, Mutex, MutexGuard};

use super::{Device, Faults, Reply, VirtualNetwork};
use crate::{NotConnected, Peer, Protocol, Received, Session};

const fn ms(time: u64) -> Duration {
    Duration::from_millis(time)
}

/// Answers whatever comes with three bytes and three datagrams, one of them to a port of nobody.
#[derive(Default)]
struct Echo {
    came: Vec<(Duration, Vec<u8>)>,
    connections: usize,
    closes: bool,
}

impl Device for Echo {
    fn connected(&mut self) {
        self.connections += 1;
    }

    fn poll(&mut self, now: Duration, received: &[u8], reply: &mut Reply) -> Duration {
        if received.is_empty() {
            return Duration::MAX;
        }
        self.came.push((now, received.to_vec()));
        reply.bytes.extend(b"abc");
        reply.datagrams = vec![(50_000, vec![1]), (50_000, vec![2]), (1, vec![3])];
        reply.closes = self.closes;
        Duration::MAX
    }
}

/// What came, and when.
type Came = (Duration, Vec<u8>, Option<Vec<u8>>, bool);

/// Asks at 0 and 10 ms, and is polled once more at 1 s.
struct Recorder {
    came: Arc<Mutex<Vec<Came>>>,
    asks: u64,
}

impl Protocol for Recorder {
    type Fault = &'static str;

    fn poll(
        &mut self,
        now: Duration,
        received: Received<'_>,
        send: &mut Vec<u8>,
    ) -> Result<Duration, &'static str> {
        if !received.bytes.is_empty() || received.datagram.is_some() || received.is_closed {
            let datagram = received.datagram.map(<[u8]>::to_vec);
            let came = (now, received.bytes.to_vec(), datagram, received.is_closed);
            self.came.lock().expect("whole").push(came);
        }
        if received.is_closed {
            return Err("closed by the device");
        }
        if self.asks < 2 && now >= ms(10) * self.asks as u32 {
            self.asks += 1;
            send.push(b'?');
        }
        Ok(match self.asks {
            0 | 1 => ms(10),
            _ if now < Duration::from_secs(1) => Duration::from_secs(1),
            _ => Duration::MAX,
        })
    }

    fn not_connected(&self, why: NotConnected) -> &'static str {
        assert_eq!(why, NotConnected::Unreachable);
        "unreachable"
    }
}

struct Fixture {
    device: Arc<Mutex<Echo>>,
    network: VirtualNetwork,
    came: Arc<Mutex<Vec<Came>>>,
    session: Session<&'static str>,
}

impl Fixture {
    fn new(faults: Faults) -> Fixture {
        let device = Arc::new(Mutex::new(Echo::default()));
        let network = VirtualNetwork::with(Arc::clone(&device));
        network.change(|now| *now = faults);
        let (came, session) = begin(&network);
        Fixture { device, network, came, session }
    }

    fn device(&self) -> MutexGuard<'_, Echo> {
        self.device.lock().expect("whole")
    }

    /// The bytes that came, each piece with its time.
    fn bytes(&self) -> Vec<(Duration, Vec<u8>)> {
        self.came.lock().expect("whole").iter().map(|(at, bytes, ..)| (*at, bytes.clone())).collect()
    }
}

fn begin(network: &VirtualNetwork) -> (Arc<Mutex<Vec<Came>>>, Session<&'static str>) {
    let came = Arc::new(Mutex::new(Vec::new()));
    let recorder = Recorder { came: Arc::clone(&came), asks: 0 };
    let peer = Peer { address: ([127, 0, 0, 1], 1).into(), timeout: ms(1000), sends_datagrams: true };
    let session = Session::begin(&network.network(), "recorder", peer, recorder, "hung up");
    (came, session.expect("no thread is needed"))
}

#[test]
fn everything_takes_its_latency_in_both_directions() {
    let all = Fixture::new(Faults { latency: ms(2), ..Faults::NONE });
    all.network.advance(ms(100));
    // Connected after 4 ms, then asked at 4 ms and 10 ms.
    assert_eq!(all.device().came, [(ms(6), b"?".to_vec()), (ms(12), b"?".to_vec())]);
    assert_eq!(all.bytes(), [(ms(8), b"abc".to_vec()), (ms(14), b"abc".to_vec())]);
    assert_eq!((all.network.now(), all.session.now()), (ms(100), ms(100)));
}

#[test]
fn the_newest_datagram_comes_with_the_next_poll() {
    let all = Fixture::new(Faults::NONE);
    all.network.advance(ms(5));
    assert_eq!(*all.came.lock().expect("whole"), [(ms(0), b"abc".to_vec(), Some(vec![2]), false)]);
}

#[test]
fn pieces_arrive_one_after_another_and_without_them_bytes_are_merged() {
    let all = Fixture::new(Faults { piece: 2, gap: ms(3), ..Faults::NONE });
    all.network.advance(ms(9));
    assert_eq!(all.bytes(), [(ms(0), b"ab".to_vec()), (ms(3), b"c".to_vec())]);
    // Connected after 40 ms, when both questions are due.
    let all = Fixture::new(Faults { latency: ms(20), ..Faults::NONE });
    all.network.advance(ms(100));
    assert_eq!(all.device().came, [(ms(60), b"??".to_vec())]);
}

#[test]
fn a_lost_byte_is_missing_and_the_others_come() {
    let all = Fixture::new(Faults { lost: Some(4), ..Faults::NONE });
    all.network.advance(ms(20));
    assert_eq!(all.bytes(), [(ms(0), b"abc".to_vec()), (ms(10), b"ac".to_vec())]);
}

#[test]
fn what_is_sent_during_silence_never_arrives() {
    let all = Fixture::new(Faults { is_silent: true, ..Faults::NONE });
    all.network.advance(ms(5));
    all.network.change(|faults| faults.is_silent = false);
    all.network.advance(ms(20));
    assert_eq!(all.device().came.len(), 2);
    assert_eq!(all.bytes(), [(ms(10), b"abc".to_vec())]);
}

#[test]
fn a_session_hears_the_last_bytes_and_then_the_end() {
    let all = Fixture::new(Faults { latency: ms(1), ..Faults::NONE });
    all.device().closes = true;
    all.network.advance(ms(20));
    assert_eq!(*all.came.lock().expect("whole"), [(ms(4), b"abc".to_vec(), Some(vec![2]), true)]);
    assert_eq!(all.session.goes_on(), Err("closed by the device"));
    assert!(all.session.is_over());
    // The other end may close it as well.
    let all = Fixture::new(Faults::NONE);
    all.network.advance(ms(5));
    all.network.close();
    all.network.advance(ms(0));
    assert_eq!(all.session.goes_on(), Err("closed by the device"));
}

#[test]
fn a_session_that_is_hung_up_is_polled_no_more() {
    let all = Fixture::new(Faults::NONE);
    all.network.advance(ms(5));
    all.session.hang_up();
    assert_eq!((all.session.goes_on(), all.session.is_over()), (Err("hung up"), true));
    all.network.advance(ms(20));
    assert_eq!(all.device().came.len(), 1);
    // Another one is heard by the same device.
    let (came, _session) = begin(&all.network);
    all.network.advance(ms(1));
    assert_eq!((all.device().connections, came.lock().expect("whole").len()), (2, 1));
}

#[test]
fn nobody_accepts_a_connection_on_an_empty_network() {
    let (_, session) = begin(&VirtualNetwork::empty());
    assert_eq!((session.goes_on(), session.is_over()), (Err("unreachable"), true));
}

/// Over sockets, as in production.
mod real_time {
    use super::super::{Server, unused_address};
    use super::*;
    use crate::Network;

    fn over_sockets(address: std::net::SocketAddr) -> (Arc<Mutex<Vec<Came>>>, Session<&'static str>) {
        let came = Arc::new(Mutex::new(Vec::new()));
        let recorder = Recorder { came: Arc::clone(&came), asks: 0 };
        let peer = Peer { address, timeout: ms(1000), sends_datagrams: true };
        let session = Session::begin(&Network::SOCKETS, "recorder", peer, recorder, "hung up");
        (came, session.expect("a thread"))
    }

    #[test]
    fn a_session_connects_exchanges_and_hears_the_end() {
        let device = Arc::new(Mutex::new(Echo { closes: true, ..Echo::default() }));
        let server = Server::start(([127, 0, 0, 1], 0).into(), Arc::clone(&device)).expect("a port");
        let (came, session) = over_sockets(server.address());
        while session.goes_on().is_ok() {
            Network::SOCKETS.wait(ms(1));
        }
        assert_eq!(session.goes_on(), Err("closed by the device"));
        let bytes: Vec<u8> =
            came.lock().expect("whole").iter().flat_map(|(_, bytes, ..)| bytes.clone()).collect();
        assert_eq!(bytes, b"abc");
        assert_eq!(device.lock().expect("whole").came.len(), 1);
    }

    #[test]
    fn hanging_up_wakes_a_session_that_waits_and_dropping_it_returns() {
        let device = Arc::new(Mutex::new(Echo::default()));
        let server = Server::start(([127, 0, 0, 1], 0).into(), Arc::clone(&device)).expect("a port");
        let (_, session) = over_sockets(server.address());
        // Both questions, which come at once where the thread was late.
        let asked = || device.lock().expect("whole").came.iter().map(|(_, bytes)| bytes.len()).sum::<usize>();
        while asked() < 2 {
            Network::SOCKETS.wait(ms(1));
        }
        // It waits for a second now, or for bytes.
        assert_eq!(session.goes_on(), Ok(()));
        session.hang_up();
        while !session.is_over() {
            std::thread::yield_now();
        }
        assert_eq!(session.goes_on(), Err("hung up"));
        drop(over_sockets(server.address()));
        let (_, session) = over_sockets(unused_address().expect("a port"));
        while session.goes_on().is_ok() {
            std::thread::yield_now();
        }
        assert_eq!(session.goes_on(), Err("unreachable"));
    }

    /// A protocol that has a mistake.
    struct Panics;

    impl Protocol for Panics {
        type Fault = &'static str;

        fn poll(&mut self, _: Duration, _: Received<'_>, _: &mut Vec<u8>) -> Result<Duration, &'static str> {
            panic!("as it should")
        }

        fn not_connected(&self, _: NotConnected) -> &'static str {
            "unreachable"
        }
    }

    #[test]
    fn a_thread_that_panics_has_ended() {
        let device = Arc::new(Mutex::new(Echo::default()));
        let server = Server::start(([127, 0, 0, 1], 0).into(), device).expect("a port");
        let peer = Peer { address: server.address(), timeout: ms(1000), sends_datagrams: false };
        let session = Session::begin(&Network::SOCKETS, "panics", peer, Panics, "closed");
        let session = session.expect("a thread");
        while session.goes_on().is_ok() {
            std::thread::yield_now();
        }
        assert_eq!(session.goes_on(), Err("closed"));
    }
}
