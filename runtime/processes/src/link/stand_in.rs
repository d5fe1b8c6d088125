//! Stands in for the processes of other machines in the shared memory of this one.
//!
//! In: a cell, put together as in each of its processes, and on which machine each process is. Out: the boards and the wake-up
//! futex that processes of other machines would have here; of each board whether it goes to another machine, or is written
//! from there.
//!
//! ```text
//! a process here   a process elsewhere    its stand-in
//! asks             answers                makes "answer i", reads "request i"
//! answers          asks                   makes "request i", reads "answer i"
//! writes a board   reads it               reads "board i"
//! reads a board    writes it              makes "board i"
//! ```
//!
//! Each machine has a plant of its own, which knows all robots and moves those of its machine. What other machines' EDPs
//! would say to it is made, because the plant opens it, and stays empty.

use std::io;
use std::path::Path;
use std::sync::{Mutex, PoisonError};

use iceoryx2::port::reader::BlackboardValue;
use iceoryx2::prelude::*;

use super::fabric::{Fabric, LinkError, Planned, make, node, open};
use super::ports::{Packet, Reads, Writes};
use super::wake_futex::WakeFutex;
use mrroc_core::fault::{ProcessId, Role};
use mrroc_core::link::envelope::{Envelope, Seal};

/// The seals of a run: on this machine, and between machines.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Seals {
    pub here: Seal,
    pub between: Seal,
}

/// Where the processes are: the place of each one's node in the list of nodes, `None` for the plant.
#[derive(Clone, Debug)]
pub(crate) struct Where {
    pub me: usize,
    pub places: Vec<Option<usize>>,
}

impl Where {
    /// Whether the process at a place is on this machine.
    pub fn is_here(&self, place: usize) -> bool {
        self.places.get(place).is_some_and(|node| node.is_none_or(|node| node == self.me))
    }

    /// The machine of a process, if it is another one.
    fn elsewhere(&self, place: usize) -> Option<usize> {
        self.places.get(place).copied().flatten().filter(|node| *node != self.me)
    }
}

/// What is made before the processes of this machine open it.
pub(crate) struct StandIn {
    node: Node<ipc::Service>,
    prefix: String,
    seals: Seals,
    /// A machine, and the futex of its processes here.
    futexes: Vec<(usize, WakeFutex)>,
    /// Number of a slot, where it comes from, what it writes, and the place that it wakes.
    incoming: Vec<(u16, usize, Writes, Option<usize>)>,
    /// Number of a slot, where it goes to, the board that it reads, and whether its writer wakes nobody.
    outgoing: Vec<(u16, usize, String, bool)>,
    /// Boards that nobody writes.
    empty: Vec<Writes>,
}

/// Numbers of the two slots of a port, or of a board.
fn slots(i: usize) -> [u16; 2] {
    // A cell has 192 processes at most, and far fewer slots than 32768.
    [u16::try_from(2 * i).unwrap_or(u16::MAX), u16::try_from(2 * i + 1).unwrap_or(u16::MAX)]
}

impl StandIn {
    /// Makes all that others open. The files are in the folder `root`; the names of the shared memory begin with `prefix`.
    ///
    /// # Errors
    /// [`LinkError`]: what could not be made.
    pub fn make(
        fabric: &Fabric,
        (root, prefix): (&Path, &str),
        seals: Seals,
        places: &Where,
    ) -> Result<StandIn, LinkError> {
        let node = node(root, prefix, "stand-in")?;
        let mut stand_in = StandIn {
            node,
            prefix: prefix.to_owned(),
            seals,
            futexes: Vec::new(),
            incoming: Vec::new(),
            outgoing: Vec::new(),
            empty: Vec::new(),
        };
        let futexes = stand_in.make_futexes(places);
        futexes.map_err(LinkError::of("the wake-up futex of another machine's processes"))?;
        let is_plant =
            |place: usize| fabric.places().get(place).is_some_and(|id: &ProcessId| id.role == Role::Plant);
        for (i, planned) in fabric.planned().iter().enumerate() {
            let [first, second] = slots(i);
            match *planned {
                Planned::Port { client, server, .. } => {
                    let (request, answer) = (format!("request {i}"), format!("answer {i}"));
                    match (places.elsewhere(client), places.elsewhere(server)) {
                        (Some(_), None) if is_plant(server) => stand_in.make_empty(&request)?,
                        (None, Some(_)) if is_plant(client) => {}
                        (Some(from), None) => {
                            stand_in.make_incoming(first, from, &request, Some(server))?;
                            stand_in.outgoing.push((second, from, answer, false));
                        }
                        (None, Some(to)) => {
                            stand_in.make_incoming(second, to, &answer, Some(client))?;
                            stand_in.outgoing.push((first, to, request, false));
                        }
                        (Some(_), Some(_)) | (None, None) => {}
                    }
                }
                Planned::Board { writer, reader, .. } => {
                    let board = format!("board {i}");
                    match (places.elsewhere(writer), places.elsewhere(reader)) {
                        (Some(_), None) if is_plant(reader) => stand_in.make_empty(&board)?,
                        (None, Some(_)) if is_plant(writer) => {}
                        (Some(from), None) => stand_in.make_incoming(first, from, &board, None)?,
                        (None, Some(to)) => stand_in.outgoing.push((first, to, board, true)),
                        (Some(_), Some(_)) | (None, None) => {}
                    }
                }
            }
        }
        Ok(stand_in)
    }

    /// One futex for all processes of a machine, under the name of each.
    fn make_futexes(&mut self, places: &Where) -> io::Result<()> {
        for place in 0..places.places.len() {
            let Some(node) = places.elsewhere(place) else { continue };
            match self.futexes.iter().find(|(known, _)| *known == node) {
                Some(_) => {
                    let first =
                        (0..place).find(|&first| places.elsewhere(first) == Some(node)).unwrap_or(place);
                    WakeFutex::share(&self.prefix, first, place)?;
                }
                None => self.futexes.push((node, WakeFutex::create(&self.prefix, place)?)),
            }
        }
        Ok(())
    }

    fn make_incoming(
        &mut self,
        slot: u16,
        from: usize,
        name: &str,
        wakes: Option<usize>,
    ) -> Result<(), LinkError> {
        let writes = make(&self.node, name)?;
        self.incoming.push((slot, from, writes, wakes));
        Ok(())
    }

    fn make_empty(&mut self, name: &str) -> Result<(), LinkError> {
        self.empty.push(make(&self.node, name)?);
        Ok(())
    }

    /// Opens what the processes of this machine have made.
    ///
    /// # Errors
    /// [`LinkError`]: what could not be opened.
    pub fn open(self) -> Result<(Incoming, Vec<Outgoing>), LinkError> {
        let mut incoming = Vec::new();
        for (slot, from, writes, wakes) in self.incoming {
            let wakes = wakes.map(|place| WakeFutex::open(&self.prefix, place)).transpose();
            let wakes = wakes.map_err(LinkError::of("the wake-up futex of a process"))?;
            incoming.push(Comes { slot, from, writes: Mutex::new((writes, (0, 0))), wakes });
        }
        let mut outgoing: Vec<_> = self
            .futexes
            .iter()
            .map(|(to, wake_futex)| Outgoing {
                to: *to,
                wake_futex: *wake_futex,
                goes: Vec::new(),
                seals: self.seals,
                next: 0,
            })
            .collect();
        for (slot, to, name, is_board) in self.outgoing {
            let reads: Reads = open(&self.node, &name)?;
            if let Some(outgoing) = outgoing.iter_mut().find(|outgoing| outgoing.to == to) {
                outgoing.goes.push(Goes { slot, reads, sent: None, is_board });
            }
        }
        Ok((Incoming { comes: incoming, seals: self.seals, _node: self.node, _empty: self.empty }, outgoing))
    }
}

/// A board that another machine writes.
struct Comes {
    slot: u16,
    from: usize,
    /// What writes it, and the number and attempt of the newest envelope.
    writes: Mutex<(Writes, (u64, u64))>,
    wakes: Option<WakeFutex>,
}

/// All boards that other machines write.
pub(crate) struct Incoming {
    comes: Vec<Comes>,
    seals: Seals,
    _node: Node<ipc::Service>,
    _empty: Vec<Writes>,
}

impl Incoming {
    /// Writes what has come from a node for a slot, and wakes its reader; returns whether that was this node's to say, and of this
    /// run, and newer than what stands there.
    pub fn came(&self, from: usize, slot: u16, envelope: &Envelope) -> bool {
        let Some(comes) = self.comes.iter().find(|comes| comes.slot == slot && comes.from == from) else {
            return false;
        };
        let Some(moved) = envelope.moved(self.seals.between, self.seals.here) else { return false };
        // No thread panics while it holds the lock.
        let mut writes = comes.writes.lock().unwrap_or_else(PoisonError::into_inner);
        let number = (moved.sequence, moved.attempt);
        // An answer that is given again has the number and the attempt of the first one.
        if number < writes.1 {
            return false;
        }
        writes.1 = number;
        writes.0.update_with_copy(Packet(moved));
        drop(writes);
        if let Some(wakes) = comes.wakes {
            wakes.wake();
        }
        true
    }
}

/// A board that another machine reads.
struct Goes {
    slot: u16,
    reads: Reads,
    /// What stood there when it was sent last.
    sent: Option<BlackboardValue<Packet>>,
    is_board: bool,
}

/// All boards that one other machine reads.
pub(crate) struct Outgoing {
    to: usize,
    wake_futex: WakeFutex,
    goes: Vec<Goes>,
    seals: Seals,
    next: usize,
}

impl Outgoing {
    /// The place of the machine.
    pub const fn to(&self) -> usize {
        self.to
    }

    /// What processes here wake when they have written something for that machine.
    pub const fn wake_futex(&self) -> WakeFutex {
        self.wake_futex
    }

    /// Whether there are boards whose writers wake nobody.
    pub fn has_boards(&self) -> bool {
        self.goes.iter().any(|goes| goes.is_board)
    }

    /// The next envelope that was not sent yet; `None` when there is none.
    pub fn next(&mut self) -> Option<(u16, Envelope)> {
        for _ in 0..self.goes.len() {
            let place = self.next % self.goes.len();
            self.next = place + 1;
            let goes = &mut self.goes[place];
            if goes.sent.as_ref().is_some_and(|sent| goes.reads.is_up_to_date(sent)) {
                continue;
            }
            // An answer that is given again looks like the first one, and is sent again.
            let shown = goes.sent.insert(goes.reads.get());
            if let Some(moved) = shown.0.moved(self.seals.here, self.seals.between) {
                return Some((goes.slot, moved));
            }
        }
        None
    }
}

#[cfg(test)]
mod tests;
