//! How long a round trip takes on this link and on the primitives that it is made of: `just bench-latency`.
//!
//! Two processes exchange a request and its answer of the size of a [`Message`]; the asking process blocks until the
//! answer has come. All kinds take turns in one run, so that they are measured under the same load. Raw samples go to
//! `target/latency/`.

mod step;
mod topology;

use std::io::{Read, Write};
use std::os::fd::{AsFd, OwnedFd};
use std::os::unix::net::UnixStream;
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::sync::atomic::{AtomicU32, Ordering};

use iceoryx2::prelude::*;
use rustix::fs::{MemfdFlags, ftruncate, memfd_create};
use rustix::mm::{MapFlags, ProtFlags, mmap};
use rustix::thread::futex;

use crate::control::{Control, Frame};
use crate::link::{Clock, Fabric, RealTime, Seal, monotonic};
use crate::machine::scheduling::ask;
use mrroc_core::cell::{Permission, Realtime};
use mrroc_core::fault::Name;
use mrroc_core::fault::{ProcessId, Role};
use mrroc_core::link::message::{Kind, Message, OrderKind};
use mrroc_core::link::{Link, Waiter};

const WARM_UP: usize = 500;
const SAMPLES: usize = 5000;
const ROUNDS: usize = 5;
const KINDS: [&str; 4] = ["mrroc", "iceoryx2", "futex", "socket"];
/// Size of an envelope \[bytes\].
const SIZE: usize = 8 * (4 + 11 + mrroc_core::payload::WORDS);
const SEAL: Seal = Seal { session: 1, epoch: 1 };

fn ids() -> [ProcessId; 2] {
    [ProcessId::MP, ProcessId::new(Role::Ecp, Name::new("peer").expect("a name"))]
}

fn folder(of: u32) -> PathBuf {
    PathBuf::from(format!("/tmp/mrl{of}"))
}

/// Asks for real time as a cell does: priority 50 where it is permitted, on this core.
fn be_real_time(core: usize) -> bool {
    let ecp = ids()[1];
    let realtime = Realtime {
        permission: Permission::BestEffort,
        priority: 50,
        lock_memory: false,
        cores: Some(vec![core]),
    };
    ask(&realtime, ecp, &[ecp]).is_nothing()
}

/// One process's end: asks once, or answers once.
trait RoundTrip {
    fn ask(&mut self);
    fn answer(&mut self);
}

struct Ours<W> {
    waiter: W,
    client: Box<dyn mrroc_core::link::Client>,
    server: Box<dyn mrroc_core::link::Server>,
    message: Message,
}

impl<W: Waiter> RoundTrip for Ours<W> {
    fn ask(&mut self) {
        self.client.send(&self.message);
        while !self.client.receive(&mut self.message) {
            self.waiter.wait(Some(self.waiter.now() + 1_000_000_000)).expect("open");
        }
    }

    fn answer(&mut self) {
        while !self.server.receive(&mut self.message) {
            self.waiter.wait(None).expect("open");
        }
        self.server.reply(&self.message);
    }
}

type Payload = [u64; SIZE / 8];

struct Bare {
    client: Option<iceoryx2::port::client::Client<ipc::Service, Payload, (), Payload, ()>>,
    server: Option<iceoryx2::port::server::Server<ipc::Service, Payload, (), Payload, ()>>,
    listener: iceoryx2::port::listener::Listener<ipc::Service>,
    notifier: iceoryx2::port::notifier::Notifier<ipc::Service>,
}

impl RoundTrip for Bare {
    fn ask(&mut self) {
        let client = self.client.as_ref().expect("asks");
        let loan = client.loan_uninit().expect("a loan").write_payload([1; SIZE / 8]);
        let pending = loan.send().expect("sent");
        self.notifier.notify().expect("notified");
        while pending.receive().expect("connected").is_none() {
            self.listener.blocking_wait(|_| ()).expect("woken");
        }
    }

    fn answer(&mut self) {
        let server = self.server.as_ref().expect("answers");
        loop {
            if let Some(active) = server.receive().expect("connected") {
                let loan = active.loan_uninit().expect("a loan").write_payload([2; SIZE / 8]);
                loan.send().expect("sent");
                self.notifier.notify().expect("notified");
                return;
            }
            self.listener.blocking_wait(|_| ()).expect("woken");
        }
    }
}

struct Futex {
    words: &'static [AtomicU32; 1024],
    last: u32,
}

impl Futex {
    const BODY: usize = 16;

    fn wait(&self, word: usize, old: u32) {
        while self.words[word].load(Ordering::Acquire) == old {
            let _ = futex::wait(&self.words[word], futex::Flags::empty(), old, None);
        }
    }

    fn put(&self, word: usize, body: usize) {
        self.words[body..body + SIZE / 4].iter().for_each(|word| word.store(1, Ordering::Relaxed));
        self.words[word].fetch_add(1, Ordering::Release);
        futex::wake(&self.words[word], futex::Flags::empty(), 1).expect("woken");
    }
}

impl RoundTrip for Futex {
    fn ask(&mut self) {
        let old = self.words[1].load(Ordering::Acquire);
        self.put(0, Self::BODY);
        self.wait(1, old);
    }

    fn answer(&mut self) {
        self.wait(0, self.last);
        self.last = self.last.wrapping_add(1);
        self.put(1, Self::BODY + SIZE / 4);
    }
}

struct Socket(UnixStream);

impl RoundTrip for Socket {
    fn ask(&mut self) {
        let mut bytes = [1; SIZE];
        self.0.write_all(&bytes).expect("sent");
        self.0.read_exact(&mut bytes).expect("answered");
    }

    fn answer(&mut self) {
        let mut bytes = [0; SIZE];
        self.0.read_exact(&mut bytes).expect("asked");
        self.0.write_all(&bytes).expect("sent");
    }
}

fn name(text: &str) -> ServiceName {
    ServiceName::new(text).expect("a name")
}

/// One end of a kind; `asks` says which end. `barrier` returns when the other end has come to the same point.
fn end(
    kind: &str,
    asks: bool,
    of: u32,
    control: &'static Control,
    shared: &OwnedFd,
    barrier: &dyn Fn(),
) -> Box<dyn RoundTrip> {
    let me = ids()[usize::from(!asks)];
    match kind {
        "mrroc" => {
            let mut fabric = Fabric::new(me, Clock::Real);
            for id in ids() {
                fabric.place(id);
            }
            let (client, server) = fabric.port(0, 1);
            fabric.create(&folder(of), &format!("mrl{of}a_"), SEAL).expect("made");
            barrier();
            fabric.connect(SEAL).expect("connected");
            barrier();
            let waiter = waiter(&fabric);
            // The node lives as long as the process.
            std::mem::forget(fabric);
            let message = Message::new(Kind::Order(OrderKind::Step));
            Box::new(Ours { waiter, client, server, message })
        }
        "iceoryx2" => {
            let mut config = Config::default();
            let path = Path::new(folder(of).to_string_lossy().as_bytes()).expect("a path");
            config.global.set_root_path(&path);
            config.global.prefix = FileName::new(format!("mrl{of}b_").as_bytes()).expect("a name");
            let node = NodeBuilder::new()
                .config(&config)
                .signal_handling_mode(SignalHandlingMode::Disabled)
                .create::<ipc::Service>()
                .expect("a node");
            let (mine, other) = if asks { ("a", "b") } else { ("b", "a") };
            let events = node.service_builder(&name(mine)).event().create().expect("an event service");
            let listener = events.listener_builder().create().expect("a listener");
            let ports = || node.service_builder(&name("p")).request_response::<Payload, Payload>();
            let server = (!asks).then(|| {
                ports()
                    .max_clients(1)
                    .max_servers(1)
                    .create()
                    .expect("a port")
                    .server_builder()
                    .create()
                    .expect("one")
            });
            barrier();
            let client =
                asks.then(|| ports().open().expect("a port").client_builder().create().expect("a client"));
            let events = node.service_builder(&name(other)).event().open().expect("an event service");
            let notifier = events.notifier_builder().create().expect("a notifier");
            barrier();
            std::mem::forget(node);
            Box::new(Bare { client, server, listener, notifier })
        }
        "futex" => {
            // SAFETY: a new mapping of 4096 bytes of a file of that size, which is never unmapped.
            #[allow(unsafe_code)]
            let memory = unsafe {
                let both = ProtFlags::READ | ProtFlags::WRITE;
                mmap(core::ptr::null_mut(), 4096, both, MapFlags::SHARED, shared.as_fd(), 0).expect("mapped")
            };
            // SAFETY: it is aligned to a page, consists of atomics, for which every value is valid, and is never
            // unmapped.
            #[allow(unsafe_code)]
            let words = unsafe { &*memory.cast::<[AtomicU32; 1024]>() };
            let last = words[0].load(Ordering::Acquire);
            barrier();
            Box::new(Futex { words, last })
        }
        _ => {
            barrier();
            let descriptor = control.descriptor().try_clone_to_owned().expect("a descriptor");
            Box::new(Socket(UnixStream::from(descriptor)))
        }
    }
}

/// The name by which the test harness knows a test of a module: its path without the crate.
fn path(module: &str, test: &str) -> String {
    let (_crate, module) = module.split_once("::").expect("a module of a crate");
    format!("{module}::{test}")
}

/// Starts this executable as a process of the measurement: it runs the test `what`, with the arguments `words`. The harness takes
/// these for one more name of a test, which no test has.
fn start(what: &str, words: &str, stdin: UnixStream, shared: &OwnedFd) -> Child {
    let shared = shared.try_clone().expect("a descriptor");
    Command::new("/proc/self/exe")
        .args(["--exact", "--ignored", "--nocapture", "--test-threads=1", what, words])
        .stdin(OwnedFd::from(stdin))
        .stdout(Stdio::from(shared))
        .stderr(Stdio::inherit())
        .spawn()
        .expect("the peer starts")
}

/// The arguments that [`start`] gave the test `what`, which this process runs; `None` where somebody else started it.
fn words(what: &str) -> Option<String> {
    let mut arguments = std::env::args().skip_while(|argument| argument != what);
    arguments.nth(1)
}

fn barrier(control: &Control) {
    control.send(&Frame::Connect).expect("sent");
    assert_eq!(control.receive().expect("came"), Frame::Connect);
}

#[test]
#[ignore = "the answering process of the measurement"]
fn peer() {
    let Some(words) = words(&path(module_path!(), "peer")) else { return };
    let mut words = words.split(' ');
    let mut next = || words.next().expect("a word");
    let (kind, core, of) = (next(), next().parse().expect("a core"), next().parse().expect("a number"));
    let stdin = std::io::stdin().as_fd().try_clone_to_owned().expect("a descriptor");
    let shared = std::io::stdout().as_fd().try_clone_to_owned().expect("a descriptor");
    let control: &'static Control = Box::leak(Box::new(Control::new(UnixStream::from(stdin))));
    let mut end = end(kind, false, of, control, &shared, &|| barrier(control));
    be_real_time(core);
    barrier(control);
    for _ in 0..WARM_UP + SAMPLES {
        end.answer();
    }
    // The process does not return to the test harness, whose output would go to the shared memory.
    std::process::exit(0);
}

/// Sorted samples of one round \[ns\].
fn round(kind: &str, cores: [usize; 2]) -> Vec<u64> {
    let of = std::process::id();
    let shared = memfd_create("latency", MemfdFlags::empty()).expect("memory");
    ftruncate(&shared, 4096).expect("memory");
    let (ours, theirs) = UnixStream::pair().expect("sockets");
    let control: &'static Control = Box::leak(Box::new(Control::new(ours)));
    let words = format!("{kind} {} {of}", cores[1]);
    let mut child = start(&path(module_path!(), "peer"), &words, theirs, &shared);
    let mut end = end(kind, true, of, control, &shared, &|| barrier(control));
    barrier(control);
    let samples = (0..WARM_UP + SAMPLES).map(|_| {
        let began = monotonic();
        end.ask();
        monotonic() - began
    });
    let mut samples: Vec<_> = samples.skip(WARM_UP).collect();
    drop(end);
    assert!(child.wait().expect("a child").success());
    let file = format!("{kind}-{}-{}.txt", cores[0], cores[1]);
    let folder = samples_folder();
    let lines: String = samples.iter().map(|sample| format!("{sample}\n")).collect();
    let mut raw =
        std::fs::OpenOptions::new().append(true).create(true).open(folder.join(file)).expect("a file");
    raw.write_all(lines.as_bytes()).expect("written");
    samples.sort_unstable();
    samples
}

#[test]
#[ignore = "measures: `just bench-latency`"]
fn round_trips_of_every_kind() {
    let root = folder(std::process::id());
    std::fs::create_dir_all(&root).expect("a folder");
    set_log_level(LogLevel::Fatal);
    for cores in [[0, 0], [0, 1]] {
        let permitted = be_real_time(cores[0]);
        println!(
            "{SIZE} bytes, cores {cores:?}, priority 50 {}",
            if permitted { "had" } else { "not permitted" }
        );
        let mut rounds = KINDS.map(|_| Vec::new());
        for _ in 0..ROUNDS {
            for (kind, rounds) in KINDS.iter().zip(&mut rounds) {
                rounds.push(round(kind, cores));
                remove_segments();
            }
        }
        for (kind, rounds) in KINDS.iter().zip(&rounds) {
            let at = |share: f64| {
                let mut all: Vec<_> =
                    rounds.iter().map(|r| r[(share * (SAMPLES - 1) as f64) as usize]).collect();
                all.sort_unstable();
                all[ROUNDS / 2] as f64 * 1e-3
            };
            println!("{kind:>10}: p50 {:7.1} p99 {:7.1} p99.9 {:7.1} us", at(0.5), at(0.99), at(0.999));
        }
    }
    let _ = std::fs::remove_dir_all(root);
}

/// Waits as a process of a cell does, with a launcher that sends nothing.
fn waiter(fabric: &Fabric) -> RealTime {
    let hears_nothing = std::sync::mpsc::channel().1;
    let samples = std::sync::Arc::new(crate::link::Samples::new());
    RealTime::new(fabric.wake_futex().expect("made"), hears_nothing, (0, 0), samples)
}

/// The folder for raw samples.
fn samples_folder() -> PathBuf {
    let folder = PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../target/latency"));
    std::fs::create_dir_all(&folder).expect("a folder");
    folder
}

/// Removes the segments of this measurement and no others.
fn remove_segments() {
    let prefix = format!("mrl{}", std::process::id());
    for entry in std::fs::read_dir("/dev/shm").into_iter().flatten().flatten() {
        if entry.file_name().to_str().is_some_and(|name| name.starts_with(&prefix)) {
            let _ = std::fs::remove_file(entry.path());
        }
    }
    let root = folder(std::process::id());
    let _ = std::fs::remove_dir_all(&root);
    let _ = std::fs::create_dir_all(&root);
}
