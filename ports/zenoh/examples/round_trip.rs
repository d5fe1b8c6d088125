//! A round trip between the MP and an ECP on another machine beside one of bare zenoh, by turns in one run: `tests/benches/peers/nodes`
//! runs it. `.. --example round_trip -- --cell FOLDER/cell.toml --processes` is the cell, `.. node b` its other node,
//! `.. echo -- --echo-at ADDRESS:PORT --keys FOLDER` on the other node answers bare zenoh, where the cell asks it with the same options.
//!
//! The MP waits by turns for nothing, for the robot `far` on the other node, which is asked for its state and answers at once, and for bare
//! zenoh: a message of the same size over a connection with the same settings. A Wait wakes at a step; so how long one takes is
//! told by the phase of its end, and that of a Wait for nothing is where it began. Bare zenoh is asked at the beginning of a step
//! as well, when the connection was idle for as long as the MP's; and once more right after a round trip of the MP, when processors and
//! caches are awake, which is told and not compared. Between a message of bare zenoh and a control thread there is a thread on both sides, too: what comes is handed over by a channel, and answered by the thread that was waiting.

use std::net::SocketAddr;
use std::path::Path;
use std::process::ExitCode;
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::time::{Duration, Instant};

use mrroc::launch::own_option;
use mrroc::prelude::*;
use mrroc_robots::{Irp6, simulated};
use serde_json::json;
use zenoh::qos::{CongestionControl, Priority};
use zenoh::{Session, Wait};

/// What crosses the network for a query: an envelope of 79 words and what is said before it.
const SIZE: usize = 8 * 79 + 16;

/// How many round trips of each kind count, and how many are warm-up.
const COUNTED: usize = 600;
const WARM_UP: usize = 100;

fn main() -> ExitCode {
    let words: Vec<String> = std::env::args().collect();
    if words.get(1).is_some_and(|word| word == "echo") {
        return echo();
    }
    mrroc::launch::nodes_over(&mrroc_zenoh::Zenoh);
    mrroc::launch(cell, mrroc_pictures::Film::new())
}

fn cell(file: &CellFile) -> Result<Cell, CellError> {
    let step = file.step().as_secs_f64();
    Ok(file.cell(&simulated())?.program(move |mp| measure(mp, step)))
}

/// Where bare zenoh is answered, if it is.
fn echo_address() -> Option<SocketAddr> {
    own_option("echo-at").map(|at| at.parse().expect("--echo-at needs an address and port"))
}

/// A session with the settings of a node's, which calls or waits.
fn bare(calls: bool, name: &str) -> Session {
    let endpoint = [format!("quic/{}", echo_address().expect("--echo-at ADDRESS:PORT"))];
    let keys = own_option("keys").expect("--keys FOLDER: its certificates");
    let file = |name: &str| Path::new(&keys).join(name).to_string_lossy().into_owned();
    let (key, certificate) = (file(&format!("{name}.key")), file(&format!("{name}.pem")));
    let none: [String; 0] = [];
    let config = json!({
        "mode": "peer",
        "listen": { "endpoints": if calls { &none[..] } else { &endpoint[..] } },
        "connect": { "endpoints": if calls { &endpoint[..] } else { &none[..] } },
        "scouting": { "multicast": { "enabled": false }, "gossip": { "enabled": false } },
        "timestamping": { "enabled": false },
        "transport": {
            "unicast": { "lowlatency": true, "qos": { "enabled": false } },
            "link": {
                "tx": { "lease": 300, "keep_alive": 4 },
                "tls": {
                    "root_ca_certificate": file("authority.pem"),
                    "listen_private_key": key, "listen_certificate": certificate,
                    "connect_private_key": key, "connect_certificate": certificate,
                    "enable_mtls": true,
                },
            },
        },
    });
    zenoh::open(zenoh::Config::from_json5(&config.to_string()).expect("a configuration"))
        .wait()
        .expect("a session")
}

/// Sends to one key, and hears another one in a thread that waits.
struct Bare {
    says: zenoh::pubsub::Publisher<'static>,
    hears: Receiver<Vec<u8>>,
    _subscriber: zenoh::pubsub::Subscriber<()>,
    _session: Session,
}

impl Bare {
    fn new(session: Session, says: &'static str, hears: &'static str) -> Bare {
        let (tells, told) = channel();
        let publisher = session.declare_publisher(says).congestion_control(CongestionControl::Block);
        let says = publisher.priority(Priority::RealTime).express(true).wait().expect("declared");
        let listens = session.declare_subscriber(hears).callback(move |sample| {
            let _ = tells.send(sample.payload().to_bytes().to_vec());
        });
        Bare { says, hears: told, _subscriber: listens.wait().expect("declared"), _session: session }
    }

    /// One round trip \[s\]; none if it takes too long.
    fn ask(&self) -> Option<f64> {
        while self.hears.try_recv().is_ok() {}
        let sent = Instant::now();
        self.says.put(vec![0_u8; SIZE]).wait().ok()?;
        self.hears.recv_timeout(Duration::from_millis(50)).ok()?;
        Some(sent.elapsed().as_secs_f64())
    }
}

fn echo() -> ExitCode {
    let bare = Bare::new(bare(false, "b"), "bench/b", "bench/a");
    println!("echoes");
    loop {
        match bare.hears.recv_timeout(Duration::from_secs(60)) {
            Ok(bytes) => bare.says.put(bytes).wait().expect("said"),
            Err(RecvTimeoutError::Timeout | RecvTimeoutError::Disconnected) => return ExitCode::SUCCESS,
        }
    }
}

/// Says when its first look was, in a step with the robots of its Wait or without any.
struct Look(Option<Instant>);

#[condition(mp)]
fn with(c: &mut Look, _robot: &State<(Irp6,)>) -> bool {
    c.0 = Some(Instant::now());
    true
}

/// For so many steps.
struct Long(u64);

#[condition(mp)]
fn long(c: &mut Long, _robots: &State<(Irp6, Irp6)>) -> bool {
    c.0 = c.0.saturating_sub(1);
    c.0 == 0
}

/// The same with no robot.
struct Alone(Option<Instant>);

#[condition(mp)]
fn alone(c: &mut Alone) -> bool {
    c.0 = Some(Instant::now());
    true
}

/// Measures in a cell whose step is `step` \[s\].
fn measure(mp: &mut Mp, step: f64) -> Result<(), Fault> {
    let (mut near, mut far) = (mp.robot::<Irp6>("near")?, mp.robot::<Irp6>("far")?);
    if echo_address().is_none() {
        return mp.wait_until((&mut near, &mut far), (), Long((20.0 / step) as u64)).map(drop);
    }
    let other = Bare::new(bare(true, "a"), "bench/a", "bench/b");
    let begun = Instant::now();
    let phase =
        |at: Option<Instant>| at.map_or(0.0, |at| at.duration_since(begun).as_secs_f64().rem_euclid(step));
    let mut found: [Vec<f64>; 5] = [const { Vec::new() }; 5];
    for round in 0..WARM_UP + COUNTED {
        let nothing = mp.wait_until((), (), Alone(None))?;
        let here = mp.wait_until((&mut near,), (), Look(None))?;
        let there = mp.wait_until((&mut far,), (), Look(None))?;
        // Once right after the MP's, and once as that is: at the beginning of a step, when nobody has spoken for one.
        let after = other.ask();
        mp.wait_until((), (), Alone(None))?;
        let bare = other.ask();
        if round >= WARM_UP {
            let phases = [nothing.0, here.0, there.0].map(phase);
            found[..3].iter_mut().zip(phases).for_each(|(list, phase)| list.push(phase));
            found[3].extend(bare);
            found[4].extend(after);
        }
    }
    let [begins, near, far, mut bare, mut warm] = found;
    // Phases are those of a circle: seen from the middle of the beginnings, which are close together.
    let around = begins[0];
    let centred = |x: &f64| (x - around + step / 2.0).rem_euclid(step) - step / 2.0;
    let mut begins: Vec<f64> = begins.iter().map(centred).collect();
    begins.sort_by(f64::total_cmp);
    let zero = around + begins[begins.len() / 2];
    let tell = |what: &str, times: &mut Vec<f64>| {
        times.sort_by(f64::total_cmp);
        let at = |share: f64| times[((times.len() - 1) as f64 * share) as usize] * 1e3;
        println!("{what:<12}{:8.3} {:8.3} {:8.3}  {}", at(0.5), at(0.9), at(0.99), times.len());
        (at(0.5), at(0.99))
    };
    println!("[ms]             50 %     90 %     99 %  of");
    let after = |times: Vec<f64>| times.iter().map(|x| (x - zero).rem_euclid(step)).collect::<Vec<_>>();
    tell("here", &mut after(near));
    let ours = tell("MP - ECP", &mut after(far));
    let theirs = tell("bare zenoh", &mut bare);
    tell(" .. at once", &mut warm);
    println!("ratio       {:8.2}          {:8.2}", ours.0 / theirs.0, ours.1 / theirs.1);
    Ok(())
}
