//! The carrier: the process that carries the messages of the launcher's machine to the other machines of a cell, and back.
//!
//! In: what stands on boards for processes elsewhere, the launcher's frames for them, and what comes from their agents. Out: the same
//! at the other side. Before it lets the launcher start anything, it has found all nodes, and each has the same program and
//! the same cell file. When a node is lost, it tells the launcher of each of its processes that it is gone; no node that
//! comes back is taken in again.

use std::io::{self, Read};
use std::os::fd::AsFd;
use std::os::unix::net::{UnixListener, UnixStream};
use std::path::Path;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};
use std::time::{Duration, Instant};

use mrroc_core::cell::{Cell, Nodes, Realtime};
use mrroc_core::fault::ProcessId;
use mrroc_core::link::Clock;
use mrroc_launch::network::{JoinOptions, NodeListener, Side, Wires, network};
use rustix::process::{Signal, set_parent_process_death_signal};

use super::absence::absent;
use super::identity::{Identity, keys};
use super::message::NodeMessage;
use super::sending::{Post, Sending, join};
use super::silence::{SILENT, Silences};
use crate::control::{Control, Frame};
use crate::launch::launcher::NO_NETWORK;
use crate::launch::process_set::FAR;
use crate::link::{Fabric, Incoming, Seal, Seals, StandIn, Where, monotonic};
use crate::machine::identity::CellId;
use crate::machine::scheduling::Lacks;
use crate::member::NoPart;
use crate::session::{Membership, Private, prefix};

/// How long nodes may take to answer before the cell is given up.
const TIMEOUT: Duration = Duration::from_secs(10);

/// How often a node that is busy is asked again.
const AGAIN: Duration = Duration::from_millis(500);

/// What happens to a carrier.
#[expect(clippy::large_enum_variant, reason = "it is looked at where it has come")]
enum Event {
    /// A node has said something, in a session.
    Came(usize, u64, NodeMessage),
    There(usize),
    Lost(usize),
    /// The launcher has said something, or is gone.
    Launcher(io::Result<Frame>),
    /// The launcher's stream for the process at a place.
    Far(usize, UnixStream),
}

/// What the network's threads call.
struct Hub {
    events: Mutex<Sender<Event>>,
    incoming: OnceLock<Incoming>,
    wires: OnceLock<Arc<dyn Wires>>,
    session: u64,
    silences: Silences,
}

impl Hub {
    fn tell(&self, event: Event) {
        // It fails when the carrier has ended.
        let _ = self.events.lock().unwrap_or_else(PoisonError::into_inner).send(event);
    }
}

impl NodeListener for Hub {
    fn came(&self, from: usize, bytes: &[u8]) {
        match NodeMessage::read(bytes) {
            Some((session, NodeMessage::Slot(slot, envelope))) if session == self.session => {
                if let Some(incoming) = self.incoming.get() {
                    incoming.came(from, slot, &envelope);
                }
            }
            Some((session, NodeMessage::Ping(sent))) => {
                if session == self.session {
                    self.silences.heard(from, monotonic());
                }
                // At once, and not behind what else is said: by the answers a node keeps its steps.
                if let Some(wires) = self.wires.get() {
                    wires.send(from, &NodeMessage::Pong(sent, monotonic()).to_bytes(session));
                }
            }
            Some((session, said)) => self.tell(Event::Came(from, session, said)),
            None => {}
        }
    }

    fn is_there(&self, node: usize) {
        self.tell(Event::There(node));
    }

    fn is_lost(&self, node: usize) {
        self.tell(Event::Lost(node));
    }
}

/// Runs the carrier `me` of the cell of the file at `file`, in the session in `folder`, until the cell is over.
///
/// # Errors
/// [`NoPart`]: it cannot take part; then no robot has moved.
pub(crate) fn run(cell: Cell, me: ProcessId, folder: &Path, file: &Path) -> Result<(), NoPart> {
    let gone = |_: io::Error| NoPart::NoLauncher(me);
    let stdin = io::stdin().as_fd().try_clone_to_owned().map_err(gone)?;
    let control = Control::new(UnixStream::from(stdin));
    let _ = set_parent_process_death_signal(Some(Signal::KILL));
    let Frame::Welcome { seal, cell: id, .. } = control.receive().map_err(gone)? else {
        return Err(NoPart::NoLauncher(me));
    };
    match carry(cell, (me, folder, file), &control, (seal, id)) {
        Ok(()) => control.send(&Frame::Over { steps: 0, time: 0, outcome: None }).map_err(gone),
        Err(text) => {
            drop(control.send(&Frame::Refuses(text.clone())));
            Err(NoPart::Told(text))
        }
    }
}

fn carry(
    cell: Cell,
    (me, folder, file): (ProcessId, &Path, &Path),
    control: &Control,
    (seal, id): (Seal, CellId),
) -> Result<(), String> {
    let text = |error: &dyn std::fmt::Display| error.to_string();
    let nodes = cell.nodes().cloned().ok_or("the cell has no nodes")?;
    let network = network().ok_or_else(|| NO_NETWORK.to_owned())?;
    let (realtime, step) = (cell.realtime().cloned(), cell.step_length());
    let membership = Membership::join(folder).map_err(|error| text(&error))?;
    let _part = crate::machine::identity::take_part(id).map_err(|error| text(&error))?;
    if membership.number != seal.session {
        return Err("its launcher is of another session".to_owned());
    }
    let mut fabric = Fabric::new(me, Clock::Real);
    cell.put_on(&mut fabric).map_err(|error| text(&error))?;
    let places = Where {
        me: nodes.of(me).ok_or("no node of the cell")?,
        places: fabric.places().iter().map(|id| nodes.of(*id)).collect(),
    };
    let seals = Seals { here: seal, between: seal };
    let private = Private::begin();
    let stand_in = StandIn::make(&fabric, (folder, &prefix(seal.session)), seals, &places);
    let stand_in = stand_in.map_err(|error| text(&error))?;
    let listener = UnixListener::bind(folder.join(FAR)).map_err(|error| text(&error))?;
    drop(private);
    let (tells, events) = channel();
    let hub = Arc::new(Hub {
        events: Mutex::new(tells),
        incoming: OnceLock::new(),
        wires: OnceLock::new(),
        session: seal.session,
        silences: Silences::of(nodes.all().len()),
    });
    let folder = keys(file);
    let joining = JoinOptions { nodes: &nodes, me: places.me, side: Side::Calls, keys: &folder };
    let wires = join(network, &joining, Arc::clone(&hub) as Arc<dyn NodeListener>, realtime.as_ref())?;
    // Set once, here.
    let post = Arc::new(Post::begin(&wires, nodes.all().len()).map_err(|error| text(&error))?);
    let _ = hub.wires.set(Arc::clone(&wires));
    let used: Vec<_> = (0..nodes.all().len())
        .filter(|node| *node != places.me && places.places.contains(&Some(*node)))
        .collect();
    let own = Identity::here(nodes.file()).map_err(|error| text(&error))?;
    meet(&nodes, &used, (own, seal), &post, &events)?;
    accept(listener, control, &hub).map_err(|error| text(&error))?;
    control.send(&Frame::Created { fingerprint: fabric.fingerprint() }).map_err(|error| text(&error))?;
    let carrier = Carrier { nodes, places, wires, post, hub, seal, far: Vec::new() };
    carrier.run(&events, (stand_in, control), (realtime.as_ref(), step))
}

/// Finds all nodes and asks each to take part.
fn meet(
    nodes: &Nodes,
    used: &[usize],
    (own, seal): (Identity, Seal),
    post: &Post,
    events: &Receiver<Event>,
) -> Result<(), String> {
    let until = Instant::now() + TIMEOUT;
    let name = |node: usize| nodes.all()[node].name.as_str().to_owned();
    let hello = NodeMessage::Hello(own, seal).to_bytes(seal.session);
    let mut agreed = vec![false; nodes.all().len()];
    let mut there = vec![false; nodes.all().len()];
    let mut again: Vec<Option<Instant>> = vec![None; nodes.all().len()];
    let mut busy: Vec<Option<String>> = vec![None; nodes.all().len()];
    while used.iter().any(|&node| !agreed[node]) {
        let now = Instant::now();
        for &node in used {
            if again[node].is_some_and(|time| now >= time) {
                again[node] = Some(now + AGAIN);
                post.say(node, hello.clone());
            }
        }
        if now >= until {
            let missing = used.iter().filter(|&&node| !agreed[node]);
            return Err(missing
                .map(|&node| match &busy[node] {
                    Some(why) => format!("node {}: {why}", name(node)),
                    None => absent(&nodes.all()[node], there[node]),
                })
                .collect::<Vec<_>>()
                .join("\n"));
        }
        match events.recv_timeout(Duration::from_millis(20)) {
            Ok(Event::There(node)) => {
                there[node] = true;
                again[node] = Some(now);
            }
            Ok(Event::Lost(node)) if agreed[node] => {
                return Err(format!("node {} is lost again", name(node)));
            }
            Ok(Event::Lost(node)) => {
                there[node] = false;
                again[node] = None;
            }
            Ok(Event::Came(node, session, said)) if session == seal.session => match said {
                NodeMessage::Agreed => {
                    agreed[node] = true;
                    again[node] = None;
                }
                // It may still be busy with the end of another run.
                NodeMessage::Refused(text) if text.starts_with(BUSY) => busy[node] = Some(text),
                NodeMessage::Refused(text) => return Err(format!("node {}: {text}", name(node))),
                _ => {}
            },
            Ok(_) | Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => return Err("its network has ended".to_owned()),
        }
    }
    Ok(())
}

/// The beginning of what an agent says that is busy.
pub(super) const BUSY: &str = "it has processes of another run";

/// Begins to hear the launcher: its frames, and a stream for each process of another machine.
fn accept(listener: UnixListener, control: &Control, hub: &Arc<Hub>) -> io::Result<()> {
    let control = control.try_clone()?;
    let heard = Arc::clone(hub);
    std::thread::Builder::new().name("launcher".to_owned()).spawn(move || {
        loop {
            let frame = control.receive();
            let ends = frame.is_err();
            heard.tell(Event::Launcher(frame));
            if ends {
                break;
            }
        }
    })?;
    let heard = Arc::clone(hub);
    std::thread::Builder::new().name("far".to_owned()).spawn(move || {
        for stream in listener.incoming() {
            let mut place = [0; 8];
            let Ok(mut stream) = stream else { break };
            if stream.read_exact(&mut place).is_ok()
                && let Ok(place) = usize::try_from(u64::from_le_bytes(place))
            {
                heard.tell(Event::Far(place, stream));
            }
        }
    })?;
    Ok(())
}

/// A process of another machine, as the launcher holds it.
enum Far {
    Runs(Control),
    /// It has ended, and the launcher was told.
    Ended,
}

struct Carrier {
    nodes: Nodes,
    places: Where,
    wires: Arc<dyn Wires>,
    post: Arc<Post>,
    hub: Arc<Hub>,
    seal: Seal,
    far: Vec<(usize, Far)>,
}

impl Carrier {
    fn run(
        mut self,
        events: &Receiver<Event>,
        (stand_in, control): (StandIn, &Control),
        (realtime, step): (Option<&Realtime>, Duration),
    ) -> Result<(), String> {
        let expected = self.places.places.iter().flatten().filter(|node| **node != self.places.me).count();
        let mut stand_in = Some(stand_in);
        let mut sending = None;
        let (mut closing, mut lost) = (false, Vec::new());
        while !(closing
            && self.far.len() == expected
            && self.far.iter().all(|(_, far)| matches!(far, Far::Ended)))
        {
            let event = match events.recv_timeout(SILENT / 20) {
                Ok(event) => event,
                Err(RecvTimeoutError::Timeout) => match self.hub.silences.fallen_silent(monotonic()) {
                    Some(node) => Event::Lost(node),
                    None => continue,
                },
                Err(RecvTimeoutError::Disconnected) => break,
            };
            match event {
                Event::Launcher(Ok(Frame::Connect)) => {
                    if let Some(stand_in) = stand_in.take() {
                        let (incoming, outgoing) = stand_in.open().map_err(|error| error.to_string())?;
                        // Set once, here.
                        let _ = self.hub.incoming.set(incoming);
                        let how = (realtime.map(|realtime| realtime.priority), step.as_nanos() as u64 / 2);
                        let begun = Sending::begin(outgoing, &self.wires, self.seal.session, how);
                        sending = Some(begun.map_err(|error| error.to_string())?);
                    }
                    let ready = control.send(&Frame::Ready { lacks: Lacks::default() });
                    ready.map_err(|error| error.to_string())?;
                }
                Event::Launcher(Ok(Frame::Close)) => closing = true,
                Event::Launcher(Ok(_)) => {}
                Event::Launcher(Err(_)) => break,
                Event::Far(place, stream) => {
                    self.begin(place, stream).map_err(|error| error.to_string())?;
                    if let Some(node) = self.places.places.get(place).copied().flatten()
                        && lost.contains(&node)
                    {
                        self.lose(node);
                    }
                }
                Event::Came(from, session, said) if session == self.seal.session => self.hear(from, said),
                Event::Came(..) | Event::There(_) => {}
                Event::Lost(node) => {
                    lost.push(node);
                    self.lose(node);
                }
            }
        }
        drop(sending);
        Ok(())
    }

    /// Begins to pass on what the launcher says to the process at a place.
    fn begin(&mut self, place: usize, stream: UnixStream) -> io::Result<()> {
        let Some(node) = self.places.places.get(place).copied().flatten() else { return Ok(()) };
        let control = Control::new(stream);
        let (reads, post, session) = (control.try_clone()?, Arc::clone(&self.post), self.seal.session);
        let number = u16::try_from(place).map_err(io::Error::other)?;
        std::thread::Builder::new().name(format!("to place {place}")).spawn(move || {
            while let Ok(frame) = reads.receive() {
                post.say(node, NodeMessage::Frame(number, frame).to_bytes(session));
            }
        })?;
        self.far.push((place, Far::Runs(control)));
        Ok(())
    }

    /// Passes on what a node says of its own processes.
    fn hear(&mut self, from: usize, said: NodeMessage) {
        match said {
            NodeMessage::Frame(place, frame) => {
                let place = usize::from(place);
                if self.places.places.get(place) != Some(&Some(from)) {
                    return;
                }
                if let Some((_, Far::Runs(control))) = self.far.iter().find(|(known, _)| *known == place) {
                    // It fails only when the launcher is gone.
                    let _ = control.send(&frame);
                }
            }
            NodeMessage::Gone(place, how)
                if self.places.places.get(usize::from(place)) == Some(&Some(from)) =>
            {
                self.end(usize::from(place), &how);
            }
            _ => {}
        }
    }

    /// Tells the launcher that all processes of a node are gone.
    fn lose(&mut self, node: usize) {
        let name = self.nodes.all()[node].name;
        let how = format!("its node {} is lost: the link is down, or the node has ended", name.as_str());
        let is_its = |place: &usize| self.places.places.get(*place) == Some(&Some(node));
        let its: Vec<_> = self.far.iter().map(|(place, _)| *place).filter(is_its).collect();
        for place in its {
            self.end(place, &how);
        }
    }

    fn end(&mut self, place: usize, how: &str) {
        if let Some((_, far)) = self.far.iter_mut().find(|(known, _)| *known == place)
            && let Far::Runs(control) = std::mem::replace(far, Far::Ended)
        {
            // It fails only when the launcher is gone.
            let _ = control.send(&Frame::Gone(how.to_owned()));
            control.hang_up();
        }
    }
}
