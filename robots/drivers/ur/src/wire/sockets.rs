//! A controller in a network.

#![expect(clippy::disallowed_methods, reason = "a job has a deadline, and waits on a thread of its own")]

use std::io::{ErrorKind, Read, Write};
use std::net::{IpAddr, SocketAddr, TcpStream};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, TryRecvError, channel};
use std::time::{Duration, Instant};

use mrroc_driver_kit::{Cutting, Door, Line, Refused};

use super::dashboard::Dashboard;
use super::primary;
use super::rtde::{Negotiated, cut, negotiate, state_of};
use super::{Heard, Job, JobState, Lost, Wire};
use crate::calibration::Calibration;
use crate::outputs::{Group, Groups};
use crate::rtde::{Answer, Package, Request};
use crate::script::Ended;
use crate::set_point::SetPoint;
use crate::state::State;
use crate::stop::Connected;

/// How long a controller may take to answer a call.
const CALL: Duration = Duration::from_secs(2);

/// How long a script may take to call this machine.
const START: Duration = Duration::from_secs(5);

/// How long a person may take to start a program at the pendant.
const PLAY: Duration = Duration::from_secs(18);

/// What a program node says that asks for a script, and the most bytes of a line that is waited for.
const ASKS: &[u8] = b"request_program\n";
const LONGEST: usize = 64;

/// How long a protective stop is tried to be released: a controller lets that be done five seconds after it.
const UNLOCK: Duration = Duration::from_secs(10);

/// The ports of a controller. Their defaults are those of every robot; others are for tests.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Ports {
    /// Of the dashboard, 29999.
    pub dashboard: u16,
    /// Of the interface that tells the calibration, 30001.
    pub primary: u16,
    /// Of the interface that takes scripts, 30002.
    pub secondary: u16,
    /// Of RTDE, 30004.
    pub rtde: u16,
}

impl Default for Ports {
    fn default() -> Self {
        Ports { dashboard: 29999, primary: 30001, secondary: 30002, rtde: 30004 }
    }
}

/// Connections with a controller: RTDE, the script's, and, for jobs, the dashboard and the interface that takes scripts.
#[derive(Debug)]
pub struct Sockets {
    robot: IpAddr,
    listen: SocketAddr,
    ports: Ports,
    rtde: Option<(Line, u8)>,
    /// The recipes by which outputs of the groups are switched.
    written: [Option<u8>; 2],
    /// A message to be sent: its place is there before the cell runs.
    bytes: Vec<u8>,
    door: Option<Door>,
    script: Option<Line>,
    connected: Connected,
    job: Option<Running>,
    node: Option<Node>,
}

/// Where a program node asks for the script.
#[derive(Debug)]
struct Node {
    at: SocketAddr,
    door: Option<Door>,
    line: Option<Line>,
    offers: String,
}

impl Node {
    /// Gives the script to a node that asks for it. It waits for nothing.
    fn serve(&mut self) {
        if let Some(line) = self.door.as_mut().and_then(Door::answer) {
            self.line = Some(line);
        }
        let Some(line) = &mut self.line else { return };
        while let Some(frame) = line.oldest() {
            if frame.bytes() == ASKS && !self.offers.is_empty() {
                // A node that has gone away asks again.
                let _ = line.send(self.offers.as_bytes());
            }
        }
        if !line.is_open() {
            self.line = None;
        }
    }
}

/// A job on a thread of its own, which ends when it is let go.
#[derive(Debug)]
struct Running {
    outcome: Receiver<JobState>,
    /// The script's call is waited for.
    starts: bool,
    until: Instant,
    ends: Arc<AtomicBool>,
}

impl Drop for Running {
    fn drop(&mut self) {
        self.ends.store(true, Ordering::Release);
    }
}

impl Sockets {
    /// A controller at `robot`, which calls this machine at `listen`. Nothing is connected yet.
    #[must_use]
    pub fn new(robot: IpAddr, listen: SocketAddr, ports: Ports) -> Sockets {
        Sockets {
            robot,
            listen,
            ports,
            rtde: None,
            written: [None; 2],
            bytes: Vec::with_capacity(64),
            door: None,
            script: None,
            connected: Connected::NotYet,
            job: None,
            node: None,
        }
    }

    /// The same, where a program node asks for the script at this address of this machine.
    #[must_use]
    pub fn asked_at(mut self, at: Option<SocketAddr>) -> Sockets {
        self.node = at.map(|at| Node { at, door: None, line: None, offers: String::new() });
        self
    }

    /// Where a program node asks for the script, while that is possible: the port that was found, where 0 was asked for.
    #[must_use]
    pub fn node(&self) -> Option<SocketAddr> {
        self.node.as_ref()?.door.as_ref().map(Door::address)
    }

    /// What was not taken of what came to this machine's port; `None` while it is closed.
    #[must_use]
    pub fn refused(&self) -> Option<Refused> {
        self.door.as_ref().map(Door::refused)
    }
}

impl Wire for Sockets {
    fn hardware(&self) -> Option<String> {
        Some(format!("Universal Robots {} at {}", self.robot, self.listen))
    }

    fn reverse(&self) -> SocketAddr {
        self.door.as_ref().map_or(self.listen, Door::address)
    }

    fn connect(&mut self, switches: Groups) -> Result<State, Lost> {
        self.disconnect();
        let door = Door::open(self.listen, self.robot, |bytes| match bytes.len() {
            0..Ended::BYTES => Cutting::More,
            _ => Cutting::Frame(Ended::BYTES),
        });
        self.door = Some(door.map_err(|_| Lost("this machine has no such address, or its port is taken"))?);
        if let Some(node) = &mut self.node {
            let door =
                Door::open(node.at, self.robot, |bytes| match bytes.iter().position(|byte| *byte == b'\n') {
                    Some(end) => Cutting::Frame(end + 1),
                    None if bytes.len() < LONGEST => Cutting::More,
                    None => Cutting::Bad,
                });
            let lost =
                |_| Lost("the port at which External Control asks for its script is taken on this machine");
            node.door = Some(door.map_err(lost)?);
        }
        let line = Line::call(SocketAddr::new(self.robot, self.ports.rtde), CALL, cut);
        let mut line = line.map_err(|_| Lost("nobody answers at its address: is it switched on?"))?;
        let Negotiated { recipe, written, state } = negotiate(&mut line, switches)?;
        (self.rtde, self.written) = (Some((line, recipe)), written);
        Ok(state)
    }

    fn switch(&mut self, group: Group, values: &[u8]) {
        let (Some((line, _)), Some(recipe)) = (&self.rtde, self.written[group as usize]) else { return };
        self.bytes.clear();
        Request::Data { recipe, values }.write(&mut self.bytes);
        // A connection that is lost is told when it is heard.
        let _ = line.send(&self.bytes);
    }

    fn calibration(&mut self) -> Result<Calibration, Lost> {
        primary::read(SocketAddr::new(self.robot, self.ports.primary))
    }

    fn disconnect(&mut self) {
        (self.job, self.script, self.rtde, self.door) = (None, None, None, None);
        if let Some(node) = &mut self.node {
            (node.door, node.line) = (None, None);
        }
        self.connected = Connected::NotYet;
    }

    fn heard(&mut self, _: Duration) -> Result<Option<Heard>, Lost> {
        if let Some(node) = &mut self.node {
            node.serve();
        }
        let Some((line, recipe)) = &mut self.rtde else { return Err(Lost("RTDE is not connected")) };
        while let Some(frame) = line.oldest() {
            let Ok(Some((package, _))) = Package::first(frame.bytes()) else { continue };
            let state = Answer::read(&package).and_then(|answer| state_of(&answer, *recipe));
            if let Some(state) = state {
                return Ok(Some(Heard { state, age: frame.age() }));
            }
        }
        if line.is_open() { Ok(None) } else { Err(Lost("the controller has closed its RTDE")) }
    }

    fn tell(&mut self, message: &SetPoint) -> bool {
        let Some(line) = &self.script else { return false };
        let was_open = line.is_open();
        let sent = line.send(&message.bytes());
        // The network takes no more: set-points have been on their way for so long that the script brakes, but what it says of
        // that is not heard any more.
        if was_open && sent.as_ref().is_err_and(|why| why.kind() == ErrorKind::WouldBlock) {
            self.connected = Connected::Ended(Some(Ended::Timeout));
        }
        sent.is_ok()
    }

    fn script(&mut self) -> Connected {
        let Some(line) = &mut self.script else { return self.connected };
        // What it says last comes before the end.
        let is_open = line.is_open();
        while let Some(frame) = line.oldest() {
            if let Some(ended) = Ended::read(frame.bytes()) {
                self.connected = Connected::Ended(Some(ended));
            }
        }
        if !is_open && self.connected == Connected::Yes {
            self.connected = Connected::Ended(None);
        }
        self.connected
    }

    fn hang_up(&mut self) {
        self.script = None;
        self.connected = Connected::NotYet;
    }

    fn begin(&mut self, job: Job) {
        let (sender, outcome) = channel();
        let ends = Arc::<AtomicBool>::default();
        let over = Arc::clone(&ends);
        let dashboard = SocketAddr::new(self.robot, self.ports.dashboard);
        let secondary = SocketAddr::new(self.robot, self.ports.secondary);
        let (starts, patience) = match job {
            Job::Start(_) => (true, START),
            Job::Offer(_) => (true, PLAY),
            Job::Unlock => (false, UNLOCK),
        };
        if starts {
            self.hang_up();
            // A call that nobody asked for; one of a script that was asked for by a node may have come before the reset.
            if !matches!(job, Job::Offer(_)) {
                drop(self.door.as_mut().and_then(Door::answer));
            }
        }
        let until = Instant::now() + patience;
        let job = match (job, &mut self.node) {
            (Job::Offer(script), Some(node)) => {
                node.offers = script;
                self.job = Some(Running { outcome, starts, until, ends });
                return;
            }
            (job, _) => job,
        };
        let thread = std::thread::Builder::new().name("controller".to_owned());
        let spawned = thread.spawn(move || {
            let outcome = match job {
                Job::Start(script) => start(dashboard, secondary, &script, &over),
                Job::Offer(_) => JobState::Refused("no address was given at which External Control asks"),
                Job::Unlock => unlock(dashboard, until, &over),
            };
            // Nobody may ask for it any more.
            let _ = sender.send(outcome);
        });
        // Without a thread nobody sends, which is told as a refusal.
        drop(spawned);
        self.job = Some(Running { outcome, starts, until, ends });
    }

    fn job(&mut self) -> JobState {
        let Some(job) = &self.job else { return JobState::None };
        let outcome = match job.outcome.try_recv() {
            // The script has been sent: it calls.
            Ok(JobState::Busy) | Err(TryRecvError::Empty) => None,
            Ok(outcome) => Some(outcome),
            Err(TryRecvError::Disconnected) if job.starts => None,
            Err(TryRecvError::Disconnected) => Some(JobState::Refused("it could not be asked")),
        };
        let waits = job.starts && outcome.is_none();
        let call = if waits { self.door.as_mut().and_then(Door::answer).filter(Line::is_open) } else { None };
        let state = outcome.or_else(|| {
            let line = call?;
            (self.script, self.connected) = (Some(line), Connected::Yes);
            Some(JobState::Done)
        });
        let is_over = Instant::now() > job.until;
        let late = || {
            JobState::Refused(match self.node {
                None => "the script was sent, and does not call this machine",
                Some(_) => "start the program with the External Control node at the pendant, then reset",
            })
        };
        match state.or_else(|| is_over.then(late)) {
            None => JobState::Busy,
            Some(state) => {
                self.job = None;
                state
            }
        }
    }

    fn wait(&mut self) {
        std::thread::sleep(Duration::from_millis(1));
    }
}

/// Sends a script, and listens to what the controller says beside it until this is over: a connection that is closed with
/// something unread takes what was sent with it.
fn start(dashboard: SocketAddr, secondary: SocketAddr, script: &str, over: &AtomicBool) -> JobState {
    // PolyScope X has no dashboard.
    if let Ok(mut dashboard) = Dashboard::call(dashboard)
        && dashboard.ask("is in remote control").is_ok_and(|answer| answer == "false")
    {
        return JobState::Local;
    }
    let sent = || -> std::io::Result<()> {
        let mut stream = TcpStream::connect_timeout(&secondary, CALL)?;
        stream.set_read_timeout(Some(Duration::from_millis(20)))?;
        stream.set_write_timeout(Some(CALL))?;
        stream.write_all(script.as_bytes())?;
        let until = Instant::now() + START;
        let mut said = [0; 4096];
        while !over.load(Ordering::Acquire) && Instant::now() < until {
            if let Ok(0) = stream.read(&mut said) {
                break;
            }
        }
        Ok(())
    };
    match sent() {
        Ok(()) => JobState::Busy,
        Err(_) => JobState::Refused("the controller takes no script at its secondary interface"),
    }
}

/// Releases a protective stop, as soon as the controller lets that be done.
fn unlock(dashboard: SocketAddr, until: Instant, over: &AtomicBool) -> JobState {
    let asked = || -> std::io::Result<JobState> {
        let mut dashboard = Dashboard::call(dashboard)?;
        if dashboard.ask("is in remote control")? == "false" {
            return Ok(JobState::Local);
        }
        dashboard.ask("close safety popup")?;
        while !over.load(Ordering::Acquire) && Instant::now() < until {
            if dashboard.ask("unlock protective stop")?.contains("releasing") {
                return Ok(JobState::Done);
            }
            std::thread::sleep(Duration::from_millis(250));
        }
        Ok(JobState::Refused("the controller does not release it"))
    };
    asked().unwrap_or(JobState::Refused("its dashboard does not answer"))
}
