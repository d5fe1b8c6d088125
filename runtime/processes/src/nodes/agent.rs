//! The agent of a node: it waits for a cell, and has the processes of its node in it.
//!
//! In: what the carrier of the launcher's machine says. Out: the processes of this node, started from this executable and its
//! cell file. A process is told what the launcher tells it; how it ends, the launcher is told. When the other side is gone,
//! all processes are told that the cell closes, robots brake, and nothing is left when the next cell comes.

use std::path::PathBuf;
use std::process::ExitCode;
use std::rc::Rc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::sync::{Arc, Mutex, OnceLock, PoisonError, RwLock};
use std::time::{Duration, Instant};

use mrroc_core::cell::{Cell, CellError, Nodes, Permission, Realtime};
use mrroc_core::console::{complain, refused, say};
use mrroc_core::fault::{Name, ProcessId, Role};
use mrroc_core::link::Clock;
use mrroc_core::suggestion::suggestion;
use mrroc_launch::network::{Hears, Joining, Side, Wires, network};

use super::carrier::{BUSY, NO_NETWORK};
use super::identity::{Identity, keys};
use super::message::Said;
use super::phase::{FOLLOWS, Figures, Phase};
use super::sending::{Sending, join};
use crate::board::StateBoard;
use crate::capacity;
use crate::control::Frame;
use crate::iceoryx::{Fabric, Incoming, Seal, Seals, StandIn, Where, monotonic};
use crate::launcher::make_shared;
use crate::process_set::{Member, Plan};
use crate::session::{CellLock, Private, Session, prefix};

/// The time between two pings, of which 64 count, and how many there must be before a cell begins.
const PING: Duration = Duration::from_millis(50);
const ENOUGH: usize = 20;

/// What an agent has of its cell.
pub(crate) struct Agent {
    nodes: Nodes,
    me: usize,
    fabric: Fabric,
    places: Where,
    own: Identity,
    plan: Plan,
    realtime: Option<Realtime>,
    step: Duration,
    stop: Duration,
    lock: CellLock,
    hub: Arc<Hub>,
    wires: Arc<dyn Wires>,
    events: Receiver<Event>,
}

/// What happens to an agent.
enum Event {
    /// A node has said something, in a session.
    Came(usize, u64, Said),
    Lost(usize),
    /// The process at a place has said something, or has ended.
    Part(usize, std::io::Result<Frame>),
}

/// What the network's threads call.
struct Hub {
    events: Mutex<Sender<Event>>,
    /// Of the run that is on: its session, and what is written for it.
    incoming: RwLock<Option<(u64, Incoming)>>,
    wires: OnceLock<Arc<dyn Wires>>,
    phase: Mutex<Phase>,
}

impl Hub {
    fn tell(&self, event: Event) {
        // It fails when the agent has ended.
        let _ = self.events.lock().unwrap_or_else(PoisonError::into_inner).send(event);
    }

    fn phase<T>(&self, does: impl FnOnce(&mut Phase) -> T) -> T {
        does(&mut self.phase.lock().unwrap_or_else(PoisonError::into_inner))
    }

    fn set_incoming(&self, incoming: Option<(u64, Incoming)>) {
        *self.incoming.write().unwrap_or_else(PoisonError::into_inner) = incoming;
    }
}

impl Hears for Hub {
    fn came(&self, from: usize, bytes: &[u8]) {
        let now = monotonic();
        match Said::read(bytes) {
            Some((session, Said::Way(way, envelope))) => {
                let incoming = self.incoming.read().unwrap_or_else(PoisonError::into_inner);
                if let Some((own, incoming)) = &*incoming
                    && *own == session
                {
                    incoming.came(from, way, &envelope);
                }
            }
            Some((session, Said::Ping(sent))) => {
                if let Some(wires) = self.wires.get() {
                    wires.send(from, &Said::Pong(sent, now).to_bytes(session));
                }
            }
            Some((_, Said::Pong(sent, answered))) => self.phase(|phase| phase.hear(sent, answered, now)),
            Some((session, said)) => self.tell(Event::Came(from, session, said)),
            None => {}
        }
    }

    fn is_there(&self, _node: usize) {}

    fn is_lost(&self, node: usize) {
        self.tell(Event::Lost(node));
    }
}

/// Runs the node `name` of the cell of the file at `file`, whose processes are started with `arguments`, until it is ended.
pub(crate) fn run(
    cell: Cell,
    name: &str,
    file: PathBuf,
    (arguments, quiet): (Vec<std::ffi::OsString>, bool),
) -> ExitCode {
    match Agent::join(cell, name, file, (arguments, quiet)) {
        Ok(agent) => agent.run(),
        Err(error) => refused(&error),
    }
}

impl Agent {
    fn join(
        mut cell: Cell,
        name: &str,
        file: PathBuf,
        (arguments, quiet): (Vec<std::ffi::OsString>, bool),
    ) -> Result<Agent, String> {
        let text = |error: &dyn std::fmt::Display| error.to_string();
        cell.check().map_err(|error: CellError| text(&error))?;
        let nodes = cell.nodes().cloned().ok_or("cell.toml has no nodes\n help: write a table [nodes.NAME] for each machine")?;
        let me = nodes.position(name).ok_or_else(|| {
            let known: Vec<_> = nodes.all().iter().map(|node| node.name.as_str().to_owned()).collect();
            format!("no node `{name}`\n help: {}", suggestion(name, &known, "the cell has"))
        })?;
        if me == nodes.mp() {
            return Err(format!("node {name} has the MP\n help: start the cell itself there, by --processes"));
        }
        let network = network().ok_or_else(|| NO_NETWORK.to_owned())?;
        let (realtime, step, stop) = (cell.realtime().cloned(), cell.step_length(), cell.stop_limit());
        let hardware = cell.hardware();
        let id = ProcessId::new(Role::Node, Name::new(name).map_err(|error| text(&error))?);
        let mut fabric = Fabric::new(id, Clock::Real);
        cell.put_on(&mut fabric).map_err(|error| text(&error))?;
        let places = Where { me, places: fabric.places().iter().map(|id| nodes.of(*id)).collect() };
        let has_any = places.places.contains(&Some(me));
        if !has_any {
            return Err(format!("node {name} has no robot and no sensor\n help: write node = \"{name}\" into a table of cell.toml"));
        }
        let lock = CellLock::take(&file, &hardware).map_err(|error| text(&error))?;
        capacity::check(fabric.places().len() + fabric.ways()).map_err(|error| text(&error))?;
        let own = Identity::here(nodes.file()).map_err(|error| text(&error))?;
        let (tells, events) = channel();
        let hub = Arc::new(Hub {
            events: Mutex::new(tells),
            incoming: RwLock::new(None),
            wires: OnceLock::new(),
            phase: Mutex::new(Phase::new()),
        });
        let folder = keys(&file);
        let joining = Joining { nodes: &nodes, me, side: Side::Waits, keys: &folder };
        let wires = join(network, &joining, Arc::clone(&hub) as Arc<dyn Hears>, realtime.as_ref())?;
        // Set once, here.
        let _ = hub.wires.set(Arc::clone(&wires));
        let permission = realtime.as_ref().map_or(Permission::BestEffort, |realtime| realtime.permission);
        let plan =
            Plan { cell: file, arguments, clock: Clock::Real, spin: 0, permission, quiet, watched: false, nodes: None };
        Ok(Agent { nodes, me, fabric, places, own, plan, realtime, step, stop, lock, hub, wires, events })
    }

    fn name(&self) -> &str {
        self.nodes.all()[self.me].name.as_str()
    }

    /// The launcher's node.
    fn mp(&self) -> usize {
        self.nodes.mp()
    }

    fn send(&self, session: u64, said: &Said) {
        self.wires.send(self.mp(), &said.to_bytes(session));
    }

    /// Takes part in one cell after the other.
    fn run(self) -> ExitCode {
        if !self.plan.quiet {
            let address = self.nodes.all()[self.me].address;
            // Nothing waits for who reads it.
            let _ = say(&format!("node {} waits at {address}\n", self.name()));
        }
        let mut next = None;
        loop {
            let (session, identity, seal) = match next.take() {
                Some(hello) => hello,
                None => match self.events.recv() {
                    Ok(Event::Came(from, session, Said::Hello(identity, seal))) if from == self.mp() => {
                        (session, identity, seal)
                    }
                    Ok(_) => continue,
                    Err(_) => return ExitCode::FAILURE,
                },
            };
            let first = self.nodes.first().map_or("", |node| node.name.as_str());
            if let Some(why) = self.own.differs(identity, first) {
                if !self.plan.quiet {
                    complain(&format!("node {}: refused: {why}", self.name()));
                }
                self.send(session, &Said::Refused(why));
                continue;
            }
            match Run::begin(&self, seal) {
                Ok(run) => next = run.go_on(),
                Err(why) => {
                    complain(&format!("node {}: {why}", self.name()));
                    self.send(session, &Said::Refused(why));
                }
            }
        }
    }
}

/// Another hello that came meanwhile.
type Next = Option<(u64, Identity, Seal)>;

/// One run of the cell.
struct Run<'a> {
    agent: &'a Agent,
    /// The run's seal, and the one on this machine.
    seals: Seals,
    session: Session,
    stand_in: Option<StandIn>,
    sending: Option<Sending>,
    /// The processes of this node by their places.
    parts: Vec<(usize, Rc<Member>)>,
    /// What is held back until the plant of this node is as far.
    held: Vec<(usize, Frame)>,
    plant: Plant,
    pings: Pings,
}

/// How far the plant of this node is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Plant {
    Starts,
    Welcome,
    Created,
    Connects,
    Ready,
    Runs,
    /// Its cell closes, or it has ended, or there is none.
    Closes,
}

impl<'a> Run<'a> {
    fn begin(agent: &'a Agent, between: Seal) -> Result<Run<'a>, String> {
        let text = |error: &dyn std::fmt::Display| error.to_string();
        let session = agent.lock.session().map_err(|error| text(&error))?;
        let seals = Seals { here: Seal { session: session.number(), epoch: between.epoch }, between };
        let boards = make_shared(Clock::Real, &session, agent.fabric.places().len()).map_err(|error| text(&error))?;
        let (_, board) = boards.ok_or("no board")?;
        let private = Private::begin();
        let stand_in =
            StandIn::make(&agent.fabric, (session.folder(), &prefix(session.number())), seals, &agent.places);
        let stand_in = stand_in.map_err(|error| text(&error))?;
        drop(private);
        *agent.hub.phase.lock().unwrap_or_else(PoisonError::into_inner) = Phase::new();
        let pings = Pings::begin(agent, between.session, board).map_err(|error| text(&error))?;
        let mut run = Run {
            agent,
            seals,
            session,
            stand_in: Some(stand_in),
            sending: None,
            parts: Vec::new(),
            held: Vec::new(),
            plant: Plant::Closes,
            pings,
        };
        for (place, id) in agent.fabric.places().iter().enumerate().filter(|(place, _)| agent.places.is_here(*place)) {
            if id.role == Role::Plant {
                run.plant = Plant::Starts;
            }
            run.start(place, *id).map_err(|error| format!("{id} cannot be started: {error}"))?;
        }
        agent.send(between.session, &Said::Agreed);
        if !agent.plan.quiet {
            complain(&format!("note: node {}: its processes start", agent.name()));
        }
        Ok(run)
    }

    fn start(&mut self, place: usize, id: ProcessId) -> std::io::Result<()> {
        let member = Rc::new(Member::spawn(id, &self.session, &self.agent.plan)?);
        let control = member.control.try_clone()?;
        control.wait_for_ever()?;
        let hub = Arc::clone(&self.agent.hub);
        self.parts.push((place, member));
        std::thread::Builder::new().name(format!("from {id}")).spawn(move || {
            loop {
                let frame = control.receive();
                let ends = frame.is_err();
                hub.tell(Event::Part(place, frame));
                if ends {
                    break;
                }
            }
        })?;
        Ok(())
    }

    /// Goes on until all processes have ended.
    fn go_on(mut self) -> Next {
        let mut next = None;
        // Until when processes have to end, once the other side is gone.
        let mut ending: Option<Instant> = None;
        while self.parts.iter().any(|(_, part)| !part.gone.get()) {
            match self.agent.events.recv_timeout(PING) {
                Ok(Event::Came(from, session, Said::Hello(identity, seal))) if from == self.agent.mp() => {
                    if ending.is_some() {
                        next = Some((session, identity, seal));
                    } else if seal != self.seals.between {
                        self.agent.send(session, &Said::Refused(format!("{BUSY}\n help: end that first")));
                    }
                }
                Ok(Event::Came(from, session, Said::Frame(place, frame)))
                    if from == self.agent.mp() && session == self.seals.between.session =>
                {
                    self.told(usize::from(place), frame);
                }
                Ok(Event::Part(place, frame)) => self.heard(place, frame),
                Ok(Event::Lost(node)) if node == self.agent.mp() && ending.is_none() => {
                    // At an orderly end the other side goes when it has heard of all ends but the plant's.
                    let goes_on = |part: &Member| part.id.role != Role::Plant && !part.gone.get();
                    if self.parts.iter().any(|(_, part)| goes_on(part)) {
                        complain(&format!(
                            "note: node {}: node {} is lost: robots stop, and all processes end",
                            self.agent.name(),
                            self.agent.nodes.all()[node].name.as_str()
                        ));
                    }
                    ending = Some(self.hang_up());
                }
                Ok(_) | Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => ending = ending.or_else(|| Some(self.hang_up())),
            }
            if ending.is_some_and(|until| Instant::now() > until) {
                self.parts.iter().filter(|(_, part)| !part.gone.get()).for_each(|(_, part)| part.kill());
            }
        }
        self.agent.hub.set_incoming(None);
        drop(self.sending);
        drop(self.pings);
        if !self.agent.plan.quiet {
            complain(&tell(self.agent.name(), &self.agent.hub.phase(|phase| phase.figures())));
        }
        next
    }

    /// Tells all processes that the launcher is gone; returns until when they have to end.
    fn hang_up(&self) -> Instant {
        self.parts.iter().for_each(|(_, part)| part.control.hang_up());
        Instant::now() + self.agent.stop + crate::process_set::CLOSING
    }

    fn part(&self, place: usize) -> Option<&Rc<Member>> {
        self.parts.iter().find(|(known, _)| *known == place).map(|(_, part)| part)
    }

    fn plant(&self) -> Option<&Rc<Member>> {
        self.parts.iter().find(|(_, part)| part.id.role == Role::Plant).map(|(_, part)| part)
    }

    /// Passes a frame of the launcher on to the process at a place, as it is on this machine.
    fn told(&mut self, place: usize, frame: Frame) {
        // The launcher has a plant of its own.
        let Some(part) = self.part(place).filter(|part| part.id.role != Role::Plant).map(Rc::clone) else { return };
        let waits = match frame {
            Frame::Connect => Plant::Created,
            Frame::Go { .. } => Plant::Ready,
            _ => Plant::Starts,
        };
        if self.plant < waits {
            self.held.push((place, frame));
            return;
        }
        let frame = match frame {
            Frame::Welcome { clock, spin, .. } => {
                Frame::Welcome { seal: self.seals.here, cell: self.session.cell(), clock, spin }
            }
            Frame::Connect => {
                if let Err(why) = self.open() {
                    complain(&format!("node {}: {why}", self.agent.name()));
                    self.hang_up();
                    return;
                }
                frame
            }
            Frame::Go { origin } => {
                let Some(origin) = self.agent.hub.phase(|phase| phase.begin(origin)) else {
                    complain(&format!("node {}: no answers to its pings", self.agent.name()));
                    self.hang_up();
                    return;
                };
                Frame::Go { origin }
            }
            other => other,
        };
        // Of each kind the plant is told the first one. It fails if the process has ended; that is heard.
        let next = match (self.plant, &frame) {
            (Plant::Starts, Frame::Welcome { .. }) => Some(Plant::Welcome),
            (Plant::Ready, Frame::Go { .. }) => Some(Plant::Runs),
            (at, Frame::Close) if at < Plant::Closes => Some(Plant::Closes),
            _ => None,
        };
        if let (Some(next), Some(plant)) = (next, self.plant()) {
            let _ = plant.control.send_now(&frame);
            self.plant = next;
        }
        let _ = part.control.send_now(&frame);
    }

    /// Opens what the processes of this node have made, and begins to carry.
    fn open(&mut self) -> Result<(), String> {
        let Some(stand_in) = self.stand_in.take() else { return Ok(()) };
        let (incoming, outgoing) = stand_in.open().map_err(|error| error.to_string())?;
        self.agent.hub.set_incoming(Some((self.seals.between.session, incoming)));
        let priority = self.agent.realtime.as_ref().map(|realtime| realtime.priority);
        let how = (priority, self.agent.step.as_nanos() as u64 / 2);
        let begun = Sending::begin(outgoing, &self.agent.wires, self.seals.between.session, how);
        self.sending = Some(begun.map_err(|error| error.to_string())?);
        if self.plant == Plant::Created
            && let Some(plant) = self.plant()
        {
            let _ = plant.control.send_now(&Frame::Connect);
            self.plant = Plant::Connects;
        }
        Ok(())
    }

    /// Takes what a process has said, or its end.
    fn heard(&mut self, place: usize, frame: std::io::Result<Frame>) {
        let Some(part) = self.part(place).map(Rc::clone) else { return };
        let number = u16::try_from(place).unwrap_or(u16::MAX);
        let session = self.seals.between.session;
        let is_plant = part.id.role == Role::Plant;
        match frame {
            Ok(frame) if is_plant => self.plant_said(&part, frame),
            Ok(frame) => self.agent.send(session, &Said::Frame(number, frame)),
            Err(_) => {
                let how = part.reap();
                if !is_plant {
                    self.agent.send(session, &Said::Gone(number, how));
                } else if self.plant < Plant::Closes {
                    complain(&format!("node {}: its plant has ended: {how}", self.agent.name()));
                    // Nothing is held back for it any more; its EDPs notice the rest.
                    self.plant = Plant::Closes;
                    self.let_go();
                }
            }
        }
    }

    fn plant_said(&mut self, plant: &Member, frame: Frame) {
        match frame {
            Frame::Created { fingerprint } if fingerprint == self.agent.fabric.fingerprint() => {
                self.plant = Plant::Created;
                self.let_go();
            }
            Frame::Ready { .. } => {
                self.plant = Plant::Ready;
                self.let_go();
            }
            // A plant that would draw a picture waits for what it is to tell with it.
            Frame::Over { .. } => plant.control.hang_up(),
            Frame::Created { .. } | Frame::Refuses(_) => {
                complain(&format!("node {}: its plant does not take part: {frame:?}", self.agent.name()));
                self.hang_up();
            }
            _ => {}
        }
    }

    /// Passes on what was held back.
    fn let_go(&mut self) {
        for (place, frame) in core::mem::take(&mut self.held) {
            self.told(place, frame);
        }
    }
}

/// What is told of the way between two machines.
fn tell(name: &str, figures: &Figures) -> String {
    let ms = |nanos: u64| nanos as f64 * 1e-6;
    let [half, most, nearly_all] = figures.round_trip.map(ms);
    format!(
        "note: node {name}: round trip {half:.2} ms (half), {most:.2} ms (99 %), {nearly_all:.2} ms (99.9 %) of {} pings, {} lost; arrivals \
         within {:.2} ms (99 %) of its steps, which have moved by {:.2} ms",
        figures.asked,
        figures.lost,
        ms(figures.jitter),
        figures.slew as f64 * 1e-6
    )
}

/// A thread that pings the launcher's node, and lets the time of this node's processes follow the answers.
struct Pings(Arc<AtomicBool>);

impl Pings {
    fn begin(agent: &Agent, session: u64, board: StateBoard) -> std::io::Result<Pings> {
        let ends = Arc::<AtomicBool>::default();
        let (over, hub, wires, mp) =
            (Arc::clone(&ends), Arc::clone(&agent.hub), Arc::clone(&agent.wires), agent.mp());
        std::thread::Builder::new().name("pings".to_owned()).spawn(move || {
            let mut asked: Option<Instant> = None;
            while !over.load(Ordering::Acquire) {
                let (slew, is_new) = hub.phase(|phase| (phase.follow(), phase.heard() < ENOUGH));
                board.slew().store(slew, Ordering::Relaxed);
                // The first ones come sooner, because the cell begins with them.
                if is_new || asked.is_none_or(|asked| asked.elapsed() >= PING) {
                    asked = Some(Instant::now());
                    hub.phase(Phase::ask);
                    wires.send(mp, &Said::Ping(monotonic()).to_bytes(session));
                }
                std::thread::sleep(FOLLOWS);
            }
        })?;
        Ok(Pings(ends))
    }
}

impl Drop for Pings {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Release);
    }
}
