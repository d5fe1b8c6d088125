//! Puts a cell together in one of its processes, and connects the ends that belong to this process.
//!
//! In: the cell, and which process this is. Out: the body of this process, with its ports and boards connected.
//!
//! Services are made in two rounds, and the launcher keeps a barrier between them. In the first round every process
//! makes its wake-up futex, the ports that it answers and the boards that it writes. When all have done so, each
//! process opens what the others have made. So every service exists before it is opened, and each is made once.

use core::cell::Cell;
use core::fmt::Display;
use std::path::Path;
use std::rc::Rc;

use iceoryx2::prelude::*;

use super::ports::{Answering, Asking, BoardEnd, End, Packet, Reads, Waker, Writes};
use super::wake_futex::WakeFutex;
use mrroc_core::fault::ProcessId;
use mrroc_core::link::Clock;
use mrroc_core::link::envelope::{Envelope, LAYOUT, Seal};
use mrroc_core::link::memory::Stuck;
use mrroc_core::link::places::Places;
use mrroc_core::link::{Board, Body, Client, Link, Preparation, Server, Simulation};
use mrroc_core::payload::layout_hash;

/// The key of a board's only value.
const KEY: u64 = 0;

/// Processes that may use one board or one direction of a port: one writes and one reads. More cost memory only.
const NODES: usize = 64;

/// The shared memory of a session could not be set up.
#[derive(Debug, thiserror::Error)]
#[error("{what} could not be made in shared memory: {why}")]
pub(crate) struct LinkError {
    what: String,
    why: String,
}

impl LinkError {
    pub(super) fn of<E: Display>(what: impl Display) -> impl FnOnce(E) -> LinkError {
        move |error| LinkError { what: what.to_string(), why: error.to_string() }
    }
}

/// A port or a board of the cell.
pub(super) enum Planned {
    Port { client: usize, server: usize, asking: End<Asking>, answering: End<Answering> },
    Board { writer: usize, reader: usize, end: End<BoardEnd> },
}

/// A cell as one of its processes sees it.
pub(crate) struct Fabric {
    me: ProcessId,
    clock: Clock,
    places: Vec<ProcessId>,
    planned: Vec<Planned>,
    body: Option<Body>,
    /// What is done before it runs.
    preparation: Option<Rc<dyn Preparation>>,
    /// Places to which messages were sent since the process was resumed, in lock-step.
    woken: Rc<Cell<Places>>,
    /// What the process sleeps on, and the prefix of all futexes' names; in real time only.
    wake_futex: Option<(WakeFutex, String)>,
    node: Option<Node<ipc::Service>>,
}

impl Fabric {
    /// An empty cell, as the process `me` holds it, by this clock.
    pub fn new(me: ProcessId, clock: Clock) -> Fabric {
        Fabric {
            me,
            clock,
            places: Vec::new(),
            planned: Vec::new(),
            body: None,
            preparation: None,
            woken: Rc::default(),
            wake_futex: None,
            node: None,
        }
    }

    /// The processes of the cell, in the order of their places.
    pub fn places(&self) -> &[ProcessId] {
        &self.places
    }

    /// What this process runs; `None` if the cell has no such process.
    pub fn take_body(&mut self) -> Option<Body> {
        self.body.take()
    }

    /// What this process does before the cell begins, if it does anything.
    pub fn take_preparation(&mut self) -> Option<Rc<dyn Preparation>> {
        self.preparation.take()
    }

    /// The places to which messages were sent.
    pub fn woken(&self) -> Rc<Cell<Places>> {
        Rc::clone(&self.woken)
    }

    /// Number of ports and boards that connect the processes.
    pub const fn connections(&self) -> usize {
        self.planned.len()
    }

    /// A hash of the processes and of what connects them: if two processes have different hashes, they put together
    /// different cells.
    pub fn fingerprint(&self) -> u64 {
        let names = self.places.iter().fold(LAYOUT, |hash, place| layout_hash(hash, &place.to_string()));
        self.planned.iter().fold(names, |hash, planned| {
            layout_hash(
                hash,
                &match planned {
                    Planned::Port { client, server, .. } => format!("port {client} {server}"),
                    Planned::Board { writer, reader, .. } => format!("board {writer} {reader}"),
                },
            )
        })
    }

    /// The ports and boards of the cell, in their order.
    pub(super) fn planned(&self) -> &[Planned] {
        &self.planned
    }

    fn here(&self, place: usize) -> bool {
        self.places[place] == self.me
    }

    /// The first round: makes what others open. The files are in the folder `root`; the names of the shared memory
    /// begin with `prefix`.
    ///
    /// # Errors
    /// [`LinkError`]: what could not be made or opened, and why.
    pub fn create(&mut self, root: &Path, prefix: &str, seal: Seal) -> Result<(), LinkError> {
        let node = node(root, prefix, &self.me.to_string())?;
        let me = self.places.iter().position(|&place| place == self.me);
        if let (Clock::Real, Some(me)) = (self.clock, me) {
            // The futex is made first, so that it exists before another process can wake this one.
            let wake_futex = WakeFutex::create(prefix, me).map_err(LinkError::of("its wake_futex"))?;
            self.wake_futex = Some((wake_futex, prefix.to_owned()));
        }
        for (i, planned) in self.planned.iter().enumerate() {
            match planned {
                Planned::Port { client, asking, .. } if self.here(*client) => {
                    asking.connect(Asking::new(make(&node, &format!("request {i}"))?, seal));
                }
                Planned::Port { server, answering, .. } if self.here(*server) => {
                    answering.connect(Answering::new(make(&node, &format!("answer {i}"))?, seal));
                }
                Planned::Board { writer, end, .. } if self.here(*writer) => {
                    end.connect(BoardEnd::Writes(make(&node, &format!("board {i}"))?, seal, Cell::new(0)));
                }
                Planned::Port { .. } | Planned::Board { .. } => {}
            }
        }
        self.node = Some(node);
        Ok(())
    }

    /// The second round: opens what others made.
    ///
    /// # Errors
    /// [`LinkError`]: what could not be made or opened, and why.
    pub fn connect(&mut self, seal: Seal) -> Result<(), LinkError> {
        let Some(node) = &self.node else { return Ok(()) };
        for (i, planned) in self.planned.iter().enumerate() {
            match planned {
                Planned::Port { client, server, asking, .. } if self.here(*client) => {
                    if let Some(Asking { end, .. }) = asking.0.get() {
                        end.meet(open(node, &format!("answer {i}"))?, self.waker(*server)?);
                    }
                }
                Planned::Port { client, server, answering, .. } if self.here(*server) => {
                    if let Some(Answering { end, .. }) = answering.0.get() {
                        end.meet(open(node, &format!("request {i}"))?, self.waker(*client)?);
                    }
                }
                Planned::Board { reader, end, .. } if self.here(*reader) => {
                    end.connect(BoardEnd::Reads(open(node, &format!("board {i}"))?, seal));
                }
                Planned::Port { .. } | Planned::Board { .. } => {}
            }
        }
        Ok(())
    }

    /// What wakes the process at `place`.
    fn waker(&self, place: usize) -> Result<Waker, LinkError> {
        match &self.wake_futex {
            None => Ok(Waker::Mark(place, Rc::clone(&self.woken))),
            Some((_, prefix)) => {
                let wake_futex = WakeFutex::open(prefix, place);
                wake_futex
                    .map(Waker::WakeFutex)
                    .map_err(LinkError::of("the wake-up futex of another process"))
            }
        }
    }

    /// What this process sleeps on; in real time only.
    pub fn wake_futex(&self) -> Option<WakeFutex> {
        self.wake_futex.as_ref().map(|(wake_futex, _)| *wake_futex)
    }
}

/// Makes a node of this name, whose files are in the folder `root` and whose shared memory has this prefix.
pub(super) fn node(root: &Path, prefix: &str, name: &str) -> Result<Node<ipc::Service>, LinkError> {
    set_log_level(LogLevel::Fatal);
    let mut config = Config::default();
    let text = root.to_string_lossy();
    let path = iceoryx2::prelude::Path::new(text.as_bytes()).map_err(LinkError::of("its folder"))?;
    config.global.set_root_path(&path);
    config.global.prefix = FileName::new(prefix.as_bytes()).map_err(LinkError::of("its prefix"))?;
    let name = NodeName::new(name).map_err(LinkError::of("its node's name"))?;
    let node = NodeBuilder::new().name(&name).config(&config);
    let node = node.signal_handling_mode(SignalHandlingMode::Disabled).create::<ipc::Service>();
    node.map_err(LinkError::of("its node"))
}

/// Makes a board that this process writes.
pub(super) fn make(node: &Node<ipc::Service>, name: &str) -> Result<Writes, LinkError> {
    let board = node
        .service_builder(&service(name)?)
        .blackboard_creator::<u64>()
        .max_readers(1)
        .max_nodes(NODES)
        .add::<Packet>(KEY, Packet(Envelope::EMPTY))
        .create()
        .map_err(LinkError::of(name))?;
    let writer = board.writer_builder().create().map_err(LinkError::of(name))?;
    writer.entry(&KEY).map_err(LinkError::of(name))
}

/// Opens a board that another process has made.
pub(super) fn open(node: &Node<ipc::Service>, name: &str) -> Result<Reads, LinkError> {
    let board = node
        .service_builder(&service(name)?)
        .blackboard_opener::<u64>()
        .open()
        .map_err(LinkError::of(name))?;
    let reader = board.reader_builder().create().map_err(LinkError::of(name))?;
    reader.entry(&KEY).map_err(LinkError::of(name))
}

fn service(name: &str) -> Result<ServiceName, LinkError> {
    ServiceName::new(name).map_err(LinkError::of("the name of a service"))
}

impl Link for Fabric {
    fn place(&mut self, process: ProcessId) -> usize {
        self.places.push(process);
        self.places.len() - 1
    }

    fn port(&mut self, client: usize, server: usize) -> (Box<dyn Client>, Box<dyn Server>) {
        let (asking, answering) = (End::new(), End::new());
        let (here, there) = (asking.clone(), answering.clone());
        self.planned.push(Planned::Port { client, server, asking, answering });
        (Box::new(here), Box::new(there))
    }

    fn board(&mut self, writer: usize, reader: usize) -> Rc<dyn Board> {
        let end = End::new();
        self.planned.push(Planned::Board { writer, reader, end: end.clone() });
        Rc::new(end)
    }

    fn body(&mut self, place: usize, body: Body) -> Result<(), Stuck> {
        if self.here(place) {
            self.body = Some(body);
        }
        Ok(())
    }

    fn prepare(&mut self, place: usize, preparation: Rc<dyn Preparation>) {
        if self.here(place) {
            self.preparation = Some(preparation);
        }
    }

    fn is_here(&self, place: usize) -> bool {
        self.here(place)
    }

    fn simulation(&self) -> Simulation {
        match self.clock {
            Clock::Virtual => Simulation::Asked,
            Clock::Real => Simulation::Free,
        }
    }

    fn closer(&self) -> Box<dyn Fn()> {
        // The launcher closes the cell when it hears that the MP's program is over.
        Box::new(|| {})
    }
}
