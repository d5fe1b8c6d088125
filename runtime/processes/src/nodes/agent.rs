//! The agent of a node: what it has of its cell, and what it hears.
//!
//! In: the cell as it is on this machine, and what the carrier of the launcher's machine says. Out: the lock of the cell, how its
//! processes are started, and events for the runs of the cell.

use std::ffi::OsString;
use std::path::PathBuf;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Mutex, OnceLock, PoisonError, RwLock};
use std::time::Duration;

use mrroc_core::cell::{Cell, CellError, Nodes, Permission, Realtime};
use mrroc_core::fault::{Name, ProcessId, Role};
use mrroc_core::link::Clock;
use mrroc_core::suggestion::suggestion;
use mrroc_launch::network::{JoinOptions, NodeListener, Side, Wires, network};

use super::identity::{Identity, keys};
use super::message::NodeMessage;
use super::phase::{Phase, allowance};
use super::sending::{Post, join};
use super::silence::Silences;
use crate::consoles::CONNECTIONS;
use crate::control::Frame;
use crate::launch::launcher::NO_NETWORK;
use crate::launch::process_set::Plan;
use crate::link::{Fabric, Incoming, Where, monotonic};
use crate::machine::capacity;
use crate::session::CellLock;

/// What an agent has of its cell.
pub(crate) struct Agent {
    pub(super) nodes: Nodes,
    pub(super) me: usize,
    pub(super) fabric: Fabric,
    pub(super) places: Where,
    pub(super) own: Identity,
    pub(super) plan: Plan,
    pub(super) realtime: Option<Realtime>,
    pub(super) step: Duration,
    pub(super) stop: Duration,
    pub(super) lock: CellLock,
    pub(super) hub: Arc<Hub>,
    pub(super) wires: Arc<dyn Wires>,
    pub(super) events: Receiver<Event>,
}

/// What happens to an agent.
#[expect(clippy::large_enum_variant, reason = "it is looked at where it has come")]
pub(super) enum Event {
    /// A node has said something, in a session.
    Came(usize, u64, NodeMessage),
    Lost(usize),
    /// The process at a place has said something, or has ended.
    Part(usize, std::io::Result<Frame>),
}

/// What the network's threads call.
pub(super) struct Hub {
    events: Mutex<Sender<Event>>,
    /// Of the run that is on: its session, and what is written for it.
    incoming: RwLock<Option<(u64, Incoming)>>,
    post: OnceLock<Post>,
    wires: OnceLock<Arc<dyn Wires>>,
    pub(super) phase: Mutex<Phase>,
    /// How long the launcher's node has said nothing.
    pub(super) silences: Silences,
}

impl Hub {
    pub(super) fn tell(&self, event: Event) {
        // It fails when the agent has ended.
        let _ = self.events.lock().unwrap_or_else(PoisonError::into_inner).send(event);
    }

    pub(super) fn phase<T>(&self, does: impl FnOnce(&mut Phase) -> T) -> T {
        does(&mut self.phase.lock().unwrap_or_else(PoisonError::into_inner))
    }

    pub(super) fn set_incoming(&self, incoming: Option<(u64, Incoming)>) {
        *self.incoming.write().unwrap_or_else(PoisonError::into_inner) = incoming;
    }
}

impl NodeListener for Hub {
    fn came(&self, from: usize, bytes: &[u8]) {
        let now = monotonic();
        match NodeMessage::read(bytes) {
            Some((session, NodeMessage::Slot(slot, envelope))) => {
                let incoming = self.incoming.read().unwrap_or_else(PoisonError::into_inner);
                if let Some((own, incoming)) = &*incoming
                    && *own == session
                {
                    incoming.came(from, slot, &envelope);
                }
            }
            Some((session, NodeMessage::Ping(sent))) => {
                // At once, and not behind what else is said: by the answers a node keeps its steps.
                if let Some(wires) = self.wires.get() {
                    wires.send(from, &NodeMessage::Pong(sent, now).to_bytes(session));
                }
            }
            Some((_, NodeMessage::Pong(sent, answered))) => {
                self.silences.heard(from, now);
                self.phase(|phase| phase.hear(sent, answered, now));
            }
            Some((session, said)) => self.tell(Event::Came(from, session, said)),
            None => {}
        }
    }

    fn is_there(&self, _node: usize) {}

    fn is_lost(&self, node: usize) {
        self.tell(Event::Lost(node));
    }
}

impl Agent {
    /// Reads the cell, takes its lock on this machine, and joins the network.
    pub(super) fn join(
        mut cell: Cell,
        name: &str,
        file: PathBuf,
        (arguments, quiet): (Vec<OsString>, bool),
    ) -> Result<Agent, String> {
        let text = |error: &dyn std::fmt::Display| error.to_string();
        cell.check().map_err(|error: CellError| text(&error))?;
        let nodes = cell
            .nodes()
            .cloned()
            .ok_or("cell.toml has no nodes\n help: write a table [nodes.NAME] for each machine")?;
        let me = nodes.position(name).ok_or_else(|| {
            let known: Vec<_> = nodes.all().iter().map(|node| node.name.as_str().to_owned()).collect();
            format!("no node `{name}`\n help: {}", suggestion(name, &known, "the cell has"))
        })?;
        if me == nodes.mp() {
            return Err(format!(
                "node {name} has the MP\n help: start the cell itself there, by --processes"
            ));
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
            return Err(format!(
                "node {name} has no robot and no sensor\n help: write node = \"{name}\" into a table of cell.toml"
            ));
        }
        let lock = CellLock::take(&file, &hardware).map_err(|error| text(&error))?;
        // A node may wait for its cell for days, and what a killed one has left takes shared memory until then.
        lock.remove_remains().map_err(|error| text(&error))?;
        capacity::check(fabric.places().len() + fabric.connections(), CONNECTIONS)
            .map_err(|error| text(&error))?;
        let own = Identity::here(nodes.file()).map_err(|error| text(&error))?;
        let (tells, events) = channel();
        let hub = Arc::new(Hub {
            events: Mutex::new(tells),
            incoming: RwLock::new(None),
            post: OnceLock::new(),
            wires: OnceLock::new(),
            phase: Mutex::new(Phase::new(allowance(step))),
            silences: Silences::of(nodes.all().len()),
        });
        let folder = keys(&file);
        let joining = JoinOptions { nodes: &nodes, me, side: Side::Waits, keys: &folder };
        let wires = join(network, &joining, Arc::clone(&hub) as Arc<dyn NodeListener>, realtime.as_ref())?;
        // Set once, here.
        let post = Post::begin(&wires, nodes.all().len()).map_err(|error| text(&error))?;
        let _ = hub.post.set(post);
        let _ = hub.wires.set(Arc::clone(&wires));
        let permission = realtime.as_ref().map_or(Permission::BestEffort, |realtime| realtime.permission);
        let plan = Plan {
            cell: file,
            arguments,
            clock: Clock::Real,
            spin: 0,
            permission,
            quiet,
            watched: false,
            outcome: None,
            nodes: None,
        };
        Ok(Agent { nodes, me, fabric, places, own, plan, realtime, step, stop, lock, hub, wires, events })
    }

    pub(super) fn name(&self) -> &str {
        self.nodes.all()[self.me].name.as_str()
    }

    /// The launcher's node.
    pub(super) fn mp(&self) -> usize {
        self.nodes.mp()
    }

    pub(super) fn send(&self, session: u64, said: &NodeMessage) {
        if let Some(post) = self.hub.post.get() {
            post.say(self.mp(), said.to_bytes(session));
        }
    }
}
