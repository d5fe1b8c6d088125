//! One run of a cell on a node.
//!
//! In: frames of the launcher, and what the processes of this node say. Out: the processes of this node, started from this
//! executable and its cell file. A process is told what the launcher tells it; how it ends, the launcher is told. When the other side
//! is gone, all processes are told that the cell closes, robots brake, and nothing is left when the next cell comes.
//!
//! The plant of this node is this run's own, and the launcher does not know of it: what goes to the others waits until it is as far.

use std::rc::Rc;
use std::sync::mpsc::RecvTimeoutError;
use std::sync::{Arc, PoisonError};
use std::time::{Duration, Instant};

use mrroc_core::console::complain;
use mrroc_core::fault::{ProcessId, Role};

use super::agent::{Agent, Event};
use super::carrier::BUSY;
use super::identity::Identity;
use super::message::NodeMessage;
use super::phase::{Figures, Phase, allowance};
use super::pings::Pings;
use super::sending::Sending;
use crate::control::Frame;
use crate::launch::launcher::make_shared;
use crate::launch::process_set::{CLOSING, Member};
use crate::link::{Seal, Seals, StandIn, monotonic};
use crate::session::{Private, Session, prefix};

/// How long a run waits before it looks whether processes are late to end.
const LOOK: Duration = Duration::from_millis(50);

/// Another hello that came meanwhile.
pub(super) type Next = Option<(u64, Identity, Seal)>;

/// One run of the cell.
pub(super) struct Run<'a> {
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
    /// Until when processes have to end, once the other side is gone.
    ending: Option<Instant>,
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
    /// Starts the processes of this node for the run of this seal.
    pub(super) fn begin(agent: &'a Agent, between: Seal) -> Result<Run<'a>, String> {
        let text = |error: &dyn std::fmt::Display| error.to_string();
        let session = agent.lock.session().map_err(|error| text(&error))?;
        let seals = Seals { here: Seal { session: session.number(), epoch: between.epoch }, between };
        let (_, board) = make_shared(&session, agent.fabric.places().len()).map_err(|error| text(&error))?;
        let private = Private::begin();
        let stand_in =
            StandIn::make(&agent.fabric, (session.folder(), &prefix(session.number())), seals, &agent.places);
        let stand_in = stand_in.map_err(|error| text(&error))?;
        drop(private);
        *agent.hub.phase.lock().unwrap_or_else(PoisonError::into_inner) = Phase::new(allowance(agent.step));
        agent.hub.silences.forget();
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
            ending: None,
        };
        for (place, id) in
            agent.fabric.places().iter().enumerate().filter(|(place, _)| agent.places.is_here(*place))
        {
            if id.role == Role::Plant {
                run.plant = Plant::Starts;
            }
            run.start(place, *id).map_err(|error| format!("{id} cannot be started: {error}"))?;
        }
        agent.send(between.session, &NodeMessage::Agreed);
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
    pub(super) fn go_on(mut self) -> Next {
        let mut next = None;
        while self.parts.iter().any(|(_, part)| !part.gone.get()) {
            match self.agent.events.recv_timeout(LOOK) {
                Ok(Event::Came(from, session, NodeMessage::Hello(identity, seal)))
                    if from == self.agent.mp() =>
                {
                    if self.ending.is_some() {
                        next = Some((session, identity, seal));
                    } else if seal != self.seals.between {
                        self.agent
                            .send(session, &NodeMessage::Refused(format!("{BUSY}\n help: end that first")));
                    }
                }
                Ok(Event::Came(from, session, NodeMessage::Frame(place, frame)))
                    if from == self.agent.mp() && session == self.seals.between.session =>
                {
                    self.told(usize::from(place), frame);
                }
                Ok(Event::Part(place, frame)) => self.heard(place, frame),
                Ok(Event::Lost(node)) if node == self.agent.mp() && self.ending.is_none() => {
                    // At an orderly end the other side goes when it has heard of all ends but the plant's.
                    let goes_on = |part: &Member| part.id.role != Role::Plant && !part.gone.get();
                    if self.parts.iter().any(|(_, part)| goes_on(part)) {
                        complain(&format!(
                            "note: node {}: node {} is lost: robots stop, and all processes end",
                            self.agent.name(),
                            self.agent.nodes.all()[node].name.as_str()
                        ));
                    }
                    self.hang_up();
                }
                Err(RecvTimeoutError::Timeout)
                    if self.agent.hub.silences.fallen_silent(monotonic()) == Some(self.agent.mp()) =>
                {
                    self.agent.hub.tell(Event::Lost(self.agent.mp()));
                }
                Ok(_) | Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => self.hang_up(),
            }
            if self.ending.is_some_and(|until| Instant::now() > until) {
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

    /// Tells all processes that the launcher is gone, and gives them the time of a stop to end.
    fn hang_up(&mut self) {
        self.parts.iter().for_each(|(_, part)| part.control.hang_up());
        self.ending.get_or_insert(Instant::now() + self.agent.stop + CLOSING);
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
        let Some(part) = self.part(place).filter(|part| part.id.role != Role::Plant).map(Rc::clone) else {
            return;
        };
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
            Ok(frame) => self.agent.send(session, &NodeMessage::Frame(number, frame)),
            Err(_) => {
                let how = part.reap();
                if !is_plant {
                    self.agent.send(session, &NodeMessage::Gone(number, how));
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

/// What is told of the network between two machines.
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
