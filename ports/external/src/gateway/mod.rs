//! The gateway of a sensor for a program on another machine: a process of its own, which is to the sensor what a program on this
//! machine is.
//!
//! In: the sensor's orders by its port, and a program's readings by a network ([`mrroc_launch::network`]). Out: orders to
//! the program, and readings to the port. So there is one adapter with one set of rules, no process with steps has a thread of
//! the network in it, and iceoryx2 lets no second program of this machine write beside the gateway.
//!
//! The sensor's process starts the gateway as `PROGRAM gateway NAME --cell FILE` when it opens, and holds the other end of its standard
//! input: the gateway ends with it, however that ends.

mod clock;
mod frame;
mod registry;

use std::io::{BufRead, BufReader, Read, Write};
use std::os::unix::process::CommandExt;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::channel;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use mrroc_launch::cell_file::ExternalEntry;
use mrroc_launch::network::{Gateway, GatewayListener, GatewayPort, Network};

use crate::message::Message;
use crate::port::{Ends, ProgramEnds, folder, monotonic};
use registry::ProgramRegistry;

/// How often the gateway looks for an order: so much later one is at most.
const LOOK: Duration = Duration::from_millis(1);

/// How long nothing is sent at most: before the cell begins, there are no orders \[ns\].
const QUIET: u64 = 20_000_000;

/// How long a gateway may take to open.
const OPENS: Duration = Duration::from_secs(10);

/// How long it may take to end.
const ENDS: Duration = Duration::from_millis(500);

/// What a gateway says when it is open.
const OPEN: &str = "open";

/// The gateway's process, which ends with this.
pub(crate) struct GatewayProcess(Child);

impl GatewayProcess {
    /// Starts the process that runs the gateway of a sensor, and waits until it is open. It says itself what is wrong.
    ///
    /// # Errors
    /// It does not open.
    pub fn start(cell: &Path, sensor: &str) -> Result<GatewayProcess, String> {
        let start = || {
            Command::new(std::env::current_exe()?)
                .args(["gateway", sensor, "--cell"])
                .arg(cell)
                .stdin(Stdio::piped())
                .stdout(Stdio::piped())
                // Ctrl-C is for the cell: a gateway that ended at once would be a sensor that is lost.
                .process_group(0)
                .spawn()
        };
        let mut child =
            start().map_err(|error: std::io::Error| format!("its gateway cannot be started: {error}"))?;
        let said = child.stdout.take();
        let opened = GatewayProcess(child);
        let (tells, told) = channel();
        std::thread::spawn(move || {
            let mut line = String::new();
            let read = said.map(|said| BufReader::new(said).read_line(&mut line));
            let _ = tells.send(read.is_some_and(|read| read.is_ok()) && line.trim_end() == OPEN);
        });
        match told.recv_timeout(OPENS) {
            Ok(true) => Ok(opened),
            Ok(false) => {
                Err("its gateway to another machine does not open; that process says why".to_owned())
            }
            Err(_) => Err("its gateway to another machine has not opened for 10 s".to_owned()),
        }
    }
}

impl Drop for GatewayProcess {
    fn drop(&mut self) {
        // The end of its input ends it.
        drop(self.0.stdin.take());
        let until = Instant::now() + ENDS;
        while self.0.try_wait().is_ok_and(|ended| ended.is_none()) {
            if Instant::now() > until {
                let _ = self.0.kill();
                let _ = self.0.wait();
                return;
            }
            std::thread::sleep(LOOK);
        }
    }
}

/// What threads of the network and the gateway's own share.
#[derive(Debug, Default)]
struct Shared {
    registry: Mutex<ProgramRegistry>,
    woken: Condvar,
    /// Who has started the gateway is gone.
    is_over: AtomicBool,
}

impl Shared {
    fn registry(&self) -> MutexGuard<'_, ProgramRegistry> {
        self.registry.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl GatewayListener for Shared {
    fn came(&self, bytes: &[u8]) {
        self.registry().came(bytes, monotonic());
        self.woken.notify_one();
    }

    fn is_there(&self, program: u64) {
        self.registry().is_there(program);
    }

    fn is_lost(&self, program: u64) {
        self.registry().is_lost(program);
    }
}

/// Runs the gateway of a sensor until the process is gone that has started it.
///
/// # Errors
/// Why it cannot be opened, and what to do.
pub(crate) fn run(entry: &ExternalEntry, network: &'static dyn Network) -> Result<(), String> {
    give_back_priority();
    let Some(address) = entry.address() else {
        return Err(format!(
            "sensor `{}` has no `address` in [sensors.{}.external]",
            entry.name(),
            entry.name()
        ));
    };
    let Ends { node } = Ends::open(&folder())?;
    let ends = ProgramEnds::open(node, entry.port())?;
    let shared = Arc::new(Shared::default());
    let keys = entry.cell_file().parent().unwrap_or(Path::new("")).join("certificates");
    let gateway = Gateway { sensor: entry.name(), address, keys: &keys };
    let port = network.open_gateway(&gateway, Arc::clone(&shared) as Arc<dyn GatewayListener>)?;
    let mut out = std::io::stdout();
    // Who has started it may be gone already, which is seen below.
    let _ = writeln!(out, "{OPEN}").and_then(|()| out.flush());
    let seen = Arc::clone(&shared);
    std::thread::spawn(move || {
        let mut input = std::io::stdin().lock();
        while input.read(&mut [0; 64]).is_ok_and(|read| read > 0) {}
        seen.is_over.store(true, Ordering::Release);
        seen.woken.notify_one();
    });
    pass(&ends, &*port, &shared);
    // The port is given back; a network may take its time for a farewell, which the end of the process says as well.
    drop(ends);
    std::process::exit(0)
}

/// Passes messages on until it is over.
fn pass(ends: &ProgramEnds, port: &dyn GatewayPort, shared: &Shared) {
    let mut sent = 0;
    while !shared.is_over.load(Ordering::Acquire) {
        let registry = shared.registry();
        let waited = shared.woken.wait_timeout(registry, LOOK);
        let mut registry = waited.map_or_else(|error| error.into_inner().0, |(registry, _)| registry);
        let (reading, holder): (Option<Message>, u64) = (registry.take(), registry.holder());
        drop(registry);
        if let Some(reading) = reading {
            ends.send(reading);
        }
        let now = monotonic();
        if let Some(order) = ends.newest() {
            port.send(&frame::order(holder, now, &order));
            sent = now;
        } else if now.saturating_sub(sent) > QUIET {
            port.send(&frame::no_order(holder, now));
            sent = now;
        }
    }
}

/// Returns to ordinary priority: the process that has started this one may be urgent.
fn give_back_priority() {
    // SAFETY: a `sched_param` of zero bytes is valid, because it holds numbers only.
    #[expect(unsafe_code, reason = "no crate of ours sets the priority of a thread")]
    let parameters: libc::sched_param = unsafe { core::mem::zeroed() };
    // SAFETY: 0 is the calling thread, and the parameters are read before the call returns.
    #[expect(unsafe_code, reason = "no crate of ours sets the priority of a thread")]
    let _ = unsafe { libc::sched_setscheduler(0, libc::SCHED_OTHER, &raw const parameters) };
}
