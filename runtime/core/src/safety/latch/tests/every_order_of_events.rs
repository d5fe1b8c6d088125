//! The stop protocol, explored in every order of events: an MP with its operator, two robots of an ECP and an EDP each, links
//! that lose, double, delay and swap messages, faults anywhere.
//!
//! The transitions are the runtime's own: [`Latching::meet`] and [`Gate::meet`]. What is modelled around them is when the MP
//! sends which order, and that a braking robot loses speed. Properties are stated by ghosts that know nothing of these
//! functions.

use stateright::{Checker, Model, Property};

use crate::safety::latch::{Admission, Event, Gate, GateRequest, Latch, Latching};

const ROBOTS: usize = 2;
/// Resets, faults and messages on one link that are explored, and the speed of a robot in braking steps.
const EPOCHS: u32 = 2;
const FAULTS: u8 = 2;
const FLIGHT: usize = 2;
const SPEED: u8 = 2;

type Message = (u32, GateRequest);

/// What a robot answers: to an order of which epoch, whether it stands, whether its gate is shut.
type Answer = (u32, bool, bool);

#[derive(Clone, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
struct RobotState {
    /// Orders on their way, in the order of their epochs.
    orders: Vec<Message>,
    ecp: Gate,
    edp: Gate,
    speed: u8,
    braking: bool,
    /// What the MP was told in this epoch: that it stands behind a shut gate, that it has been reset.
    known_at_rest: bool,
    known_reset: bool,
    /// Ghosts: stopped or faulty and not reset since; the epoch of its last reset.
    ghost_latched: bool,
    ghost_epoch: u32,
}

#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
struct CellState {
    latching: Latching,
    epoch: u32,
    robots: [RobotState; ROBOTS],
    faults: u8,
    /// Ghosts: the button's level, acknowledged since the last stop, edges that count, restarts, a demand that should not
    /// have been accepted.
    ghost_pressed: bool,
    ghost_acknowledged: bool,
    ghost_edges: u8,
    ghost_restarts: u8,
    ghost_broken: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Action {
    /// The MP sends a robot what its latch asks for.
    Order(usize),
    /// An order in flight arrives, and will once more, or not; or it is lost.
    Deliver {
        robot: usize,
        place: usize,
        again: bool,
        arrives: Arrives,
    },
    Lose {
        robot: usize,
        place: usize,
    },
    /// A braking robot loses speed.
    Brake(usize),
    /// A fault of the robot, or a demand that stayed away for too long.
    Fault(usize),
    /// The MP notices a fault of its own.
    MpFault,
    /// Robots should stand by now, whether they say so or not.
    TimeIsOver,
    Acknowledge,
    Press(bool),
}

/// How far an order comes, and its answer back.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Arrives {
    /// At the ECP; the request to the EDP is lost.
    AtEcp,
    /// At the EDP; the answer is lost.
    AtEdp,
    /// The answer is back at the MP.
    Back,
}

struct StopProtocol;

impl CellState {
    /// The latch meets an event; what the MP does about its new place.
    fn meet(&mut self, event: Event) -> bool {
        let before = self.latching.latch;
        let (next, said) = self.latching.meet(event);
        self.latching = next;
        let after = next.latch;
        if after == Latch::Stopping && before != Latch::Stopping {
            self.ghost_acknowledged = false;
            self.robots.iter_mut().for_each(|robot| robot.known_at_rest = false);
        }
        if after == Latch::Resetting && before != Latch::Resetting {
            self.epoch += 1;
            self.robots.iter_mut().for_each(|robot| robot.known_reset = false);
        }
        said.is_ok()
    }

    fn order(&mut self, i: usize) -> bool {
        let asked = match self.latching.latch {
            Latch::Clear => GateRequest::Move,
            Latch::Stopping | Latch::Latched | Latch::Acknowledged => GateRequest::Stop,
            Latch::Resetting => GateRequest::Reset,
        };
        let message = (self.epoch, asked);
        let orders = &mut self.robots[i].orders;
        if orders.len() == FLIGHT || orders.contains(&message) {
            return false;
        }
        orders.push(message);
        orders.sort();
        true
    }

    fn deliver(&mut self, robot: usize, place: usize, again: bool, arrives: Arrives) -> Option<Answer> {
        let robot = &mut self.robots[robot];
        let order = if again { robot.orders[place] } else { robot.orders.remove(place) };
        let request = robot.pass(order)?;
        if arrives == Arrives::AtEcp {
            return None;
        }
        let (answer, broken) = robot.act(request);
        self.ghost_broken |= broken;
        answer
    }

    /// The MP hears an answer. One to an order of another epoch is no answer to this one's.
    fn hear(&mut self, robot: usize, (epoch, stands, latched): Answer) {
        if epoch != self.epoch {
            return;
        }
        let robot = &mut self.robots[robot];
        robot.known_at_rest = stands && latched;
        robot.known_reset = stands && !latched;
        if latched && matches!(self.latching.latch, Latch::Clear | Latch::Resetting) {
            self.meet(Event::Fault);
        }
        self.conclude();
    }

    /// What the MP knows decides about the latch.
    fn conclude(&mut self) {
        let at_rest = self.robots.iter().all(|robot| robot.known_at_rest);
        let persists = Event::Cause { persists: !at_rest };
        match self.latching.latch {
            Latch::Stopping if at_rest => {
                self.meet(Event::Standstill);
                self.meet(persists);
            }
            Latch::Latched | Latch::Acknowledged => {
                self.meet(persists);
            }
            Latch::Resetting if self.robots.iter().all(|robot| robot.known_reset) => {
                self.meet(Event::Restart);
                self.ghost_restarts += 1;
            }
            Latch::Clear | Latch::Stopping | Latch::Resetting => {}
        }
    }
}

impl RobotState {
    fn shut_down(&mut self) {
        self.edp = self.edp.closed();
        self.ghost_latched = true;
        self.braking = self.speed > 0;
    }

    /// The ECP's part: what request an order becomes, if any.
    fn pass(&mut self, (epoch, asked): Message) -> Option<Message> {
        let (gate, admission) = self.ecp.meet(epoch, asked, true);
        self.ecp = gate;
        match admission {
            Admission::Ignored => None,
            Admission::Done => Some((epoch, asked)),
            // It answers with what is latched, and its EDP is told to stop.
            Admission::Refused => Some((epoch, GateRequest::Stop)),
        }
    }

    /// The EDP's part: its answer, and whether a demand was accepted that must not have been.
    fn act(&mut self, (epoch, asked): Message) -> (Option<Answer>, bool) {
        let stands = self.speed == 0;
        let (gate, admission) = self.edp.meet(epoch, asked, stands);
        self.edp = gate;
        if admission == Admission::Ignored {
            return (None, false);
        }
        let mut broken = false;
        match (asked, admission) {
            (GateRequest::Move, Admission::Done) => {
                broken = self.ghost_latched || epoch != self.ghost_epoch;
                (self.speed, self.braking) = (SPEED, false);
            }
            (GateRequest::Reset, Admission::Done) => {
                (self.ghost_latched, self.ghost_epoch) = (false, epoch);
            }
            (GateRequest::Stop, _) | (_, Admission::Refused) => {
                self.shut_down();
                self.ghost_epoch = self.ghost_epoch.max(epoch);
            }
            (GateRequest::Look, _) | (_, Admission::Ignored) => {}
        }
        let latched = admission == Admission::Refused || self.ghost_latched;
        // An ECP behind whose back its EDP has latched hears of it now.
        if latched {
            self.ecp = self.ecp.closed();
        }
        (Some((epoch, self.speed == 0, latched)), broken)
    }
}

impl Model for StopProtocol {
    type State = CellState;
    type Action = Action;

    fn init_states(&self) -> Vec<CellState> {
        vec![CellState::default()]
    }

    fn actions(&self, state: &CellState, actions: &mut Vec<Action>) {
        actions.extend([Action::MpFault, Action::TimeIsOver, Action::Acknowledge]);
        actions.push(Action::Press(!state.ghost_pressed));
        actions.push(Action::Press(true));
        for (i, robot) in state.robots.iter().enumerate() {
            actions.push(Action::Order(i));
            actions.push(Action::Fault(i));
            for place in 0..robot.orders.len() {
                for arrives in [Arrives::AtEcp, Arrives::AtEdp, Arrives::Back] {
                    for again in [true, false] {
                        actions.push(Action::Deliver { robot: i, place, again, arrives });
                    }
                }
                actions.push(Action::Lose { robot: i, place });
            }
            if robot.braking {
                actions.push(Action::Brake(i));
            }
        }
    }

    fn next_state(&self, last: &CellState, action: Action) -> Option<CellState> {
        let mut state = last.clone();
        match action {
            Action::Order(i) => {
                if !state.order(i) {
                    return None;
                }
            }
            Action::Deliver { robot, place, again, arrives } => {
                let answer = state.deliver(robot, place, again, arrives);
                if let (Some(answer), Arrives::Back) = (answer, arrives) {
                    state.hear(robot, answer);
                }
            }
            Action::Lose { robot, place } => drop(state.robots[robot].orders.remove(place)),
            Action::Brake(i) => {
                let robot = &mut state.robots[i];
                robot.speed -= 1;
                robot.braking = robot.speed > 0;
            }
            Action::Fault(i) => {
                if state.faults == FAULTS {
                    return None;
                }
                state.faults += 1;
                state.robots[i].shut_down();
            }
            Action::MpFault => {
                if state.faults == FAULTS {
                    return None;
                }
                state.faults += 1;
                state.meet(Event::Fault);
            }
            Action::TimeIsOver => {
                if state.latching.latch != Latch::Stopping {
                    return None;
                }
                state.meet(Event::Standstill);
                state.conclude();
            }
            Action::Acknowledge => {
                if state.meet(Event::Acknowledge) {
                    state.ghost_acknowledged = true;
                }
            }
            Action::Press(pressed) => {
                let rises = pressed && !state.ghost_pressed;
                state.ghost_pressed = pressed;
                let at_rest = state.robots.iter().all(|robot| robot.known_at_rest);
                let counts = rises && state.ghost_acknowledged && at_rest;
                state.ghost_edges += u8::from(counts && state.latching.latch == Latch::Acknowledged);
                state.meet(Event::Reset { pressed });
            }
        }
        // Robots are alike: which of them is the first does not matter.
        state.robots.sort();
        Some(state)
    }

    fn properties(&self) -> Vec<Property<Self>> {
        vec![
            Property::<Self>::always(
                "no demand is accepted after the latch or of another epoch",
                |_, state| !state.ghost_broken,
            ),
            Property::<Self>::always("what is latched and moves is braking", |_, state| {
                state.robots.iter().all(|robot| !robot.ghost_latched || robot.speed == 0 || robot.braking)
            }),
            Property::<Self>::always("nothing restarts without a rising edge that counts", |_, state| {
                state.ghost_restarts <= state.ghost_edges
            }),
            Property::<Self>::always("a reset begins at standstill, and nothing moves in it", |_, state| {
                let at_rest = state.robots.iter().all(|robot| robot.speed == 0);
                state.latching.latch != Latch::Resetting || at_rest
            }),
            Property::<Self>::sometimes("a robot moves after a reset", |_, state| {
                state.ghost_restarts == 1 && state.robots.iter().any(|robot| robot.speed > 0)
            }),
            Property::<Self>::sometimes(
                "an order from before the stop arrives after a restart",
                |_, state| {
                    let is_old = |order: &Message| order.0 < state.epoch && order.1 == GateRequest::Move;
                    state.ghost_restarts == 1
                        && state.robots.iter().any(|robot| robot.orders.iter().any(is_old))
                },
            ),
        ]
    }

    fn within_boundary(&self, state: &CellState) -> bool {
        state.epoch <= EPOCHS
    }
}

#[test]
fn fault_36_the_stop_protocol_keeps_its_promises_in_every_order_of_events() {
    let checker = StopProtocol.checker().threads(2).spawn_bfs().join();
    println!(
        "{} states, {} of them unique, depth {}",
        checker.state_count(),
        checker.unique_state_count(),
        checker.max_depth()
    );
    checker.assert_properties();
}
