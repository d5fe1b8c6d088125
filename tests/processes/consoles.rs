//! Many consoles at a time.

use std::fs;
use std::io::{BufRead, BufReader, Write};
use std::os::linux::net::SocketAddrExt;
use std::os::unix::net::{SocketAddr, UnixStream};
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};

use rustix::net::sockopt::socket_peercred;

use crate::launch::{Launch, Place};
use crate::operator::{ask, done, operate, socket};

/// The most consoles that are served at a time.
const SERVED: usize = 128;

/// A console that is a socket of this process.
struct Line {
    asks: UnixStream,
    hears: BufReader<UnixStream>,
}

impl Line {
    fn new(socket: &Path) -> Line {
        let asks = UnixStream::connect(socket).expect("connected");
        let hears = BufReader::new(asks.try_clone().expect("cloned"));
        Line { asks, hears }
    }

    fn send(&mut self, request: &str) {
        // It may have been told already that there is no place for it.
        let _ = writeln!(self.asks, "{request}");
    }

    /// The first line of the next answer.
    fn hear(&mut self) -> String {
        let mut line = String::new();
        self.hears.read_line(&mut line).expect("an answer");
        let first = line.clone();
        while first == "picture\n" && line != "end\n" {
            line.clear();
            assert_ne!(self.hears.read_line(&mut line).expect("a picture"), 0, "cut");
        }
        first
    }
}

/// The addresses of the console server of a launch: its socket, and its name.
fn addresses(place: &Place, launch: &Launch) -> [SocketAddr; 2] {
    let is_its = |address: &SocketAddr| {
        let peer = UnixStream::connect_addr(address).and_then(|stream| Ok(socket_peercred(&stream)?));
        peer.is_ok_and(|peer| peer.pid.as_raw_nonzero().get() == launch.pid())
    };
    let list = fs::read_to_string("/proc/net/unix").expect("the list of sockets");
    let names = list.lines().filter_map(|line| line.rsplit_once(" @").map(|(_, name)| name));
    let consoles = names.filter(|name| name.starts_with("mrroc-cell-") && name.ends_with("-console"));
    let mut addresses = consoles.map(|name| SocketAddr::from_abstract_name(name).expect("a name"));
    let named = addresses.find(is_its).expect("the cell has a name");
    [SocketAddr::from_pathname(socket(place)).expect("a path"), named]
}

/// Does some work while a thread connects again and again to each of these addresses, and keeps up to so many connections.
fn while_others_connect<T>(addresses: &[SocketAddr], kept: usize, work: impl FnOnce() -> T) -> T {
    let over = AtomicBool::new(false);
    let connect = |address: &SocketAddr| {
        let mut all = Vec::new();
        while !over.load(Ordering::Acquire) {
            if all.len() >= kept {
                all.clear();
            }
            if let Ok(stream) = UnixStream::connect_addr(address) {
                all.push(stream);
            }
        }
    };
    std::thread::scope(|scope| {
        for address in addresses {
            scope.spawn(|| connect(address));
        }
        let ended = std::panic::catch_unwind(std::panic::AssertUnwindSafe(work));
        over.store(true, Ordering::Release);
        ended.unwrap_or_else(|panic| std::panic::resume_unwind(panic))
    })
}

#[test]
fn fault_63_orders_are_carried_out_while_consoles_connect_without_end() {
    let place = Place::new(63);
    let operator = |launch: &mut Launch| {
        let addresses = addresses(&place, launch);
        done(&place, &["suspend"], "suspended: step ");
        while_others_connect(&addresses, 0, || {
            for percent in 1..12 {
                let percent = format!("{percent}%");
                done(&place, &["speed", &percent], &format!("speed {percent}: step "));
            }
        });
        // These never say anything, and never go: there may be no place for other orders, which is said, but for stop.
        while_others_connect(&addresses, 300, || {
            for _ in 0..5 {
                let (status, said) = ask(&place, &["status"]);
                let refused = status == Some(1) && said.starts_with("refused: there are too many consoles");
                assert!(
                    refused || status == Some(0) && said.starts_with("suspended: "),
                    "{status:?}: {said}"
                );
            }
            done(&place, &["stop"], "stopping: step ")
        })
    };
    operate(&place, operator, |launch, status, _| {
        assert!(status == Some(1) && launch.said().contains("by the operator"), "{}", launch.said());
    });
}

#[test]
fn fault_63_all_of_a_hundred_consoles_are_answered_and_one_too_many_is_told_so() {
    let place = Place::new(64);
    let operator = |_: &mut Launch| {
        let socket = socket(&place);
        done(&place, &["suspend"], "suspended: step ");
        let mut consoles: Vec<_> = (0..100).map(|_| Line::new(&socket)).collect();
        for request in ["status", "resume", "status"] {
            consoles.iter_mut().for_each(|console| console.send(request));
            let answers: Vec<_> = consoles.iter_mut().map(Line::hear).collect();
            let right = |answer: &String| match request {
                "status" => answer.starts_with("picture "),
                // One of them takes the token.
                _ => answer.starts_with("done resumed: ") || answer.contains("holds the control token"),
            };
            assert!(answers.iter().all(right), "{request}: {answers:?}");
        }
        // All places are taken by consoles that have asked for something.
        while consoles.len() < SERVED {
            let mut console = Line::new(&socket);
            console.send("status");
            assert!(console.hear().starts_with("picture "));
            consoles.push(console);
        }
        let mut further = Line::new(&socket);
        further.send("status");
        assert!(further.hear().starts_with("refused there are too many consoles"));
        assert_eq!(further.hear(), "", "it is disconnected");
        // What ends a hold is taken all the same, as a stop is.
        let mut lets_go = Line::new(&socket);
        lets_go.send("let-go 1");
        let answer = lets_go.hear();
        assert!(answer.starts_with("done "), "{answer}");
        done(&place, &["stop"], "stopping: step ")
    };
    operate(&place, operator, |launch, status, _| {
        assert!(status == Some(1) && launch.said().contains("by the operator"), "{}", launch.said());
    });
}
