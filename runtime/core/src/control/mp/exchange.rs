//! One exchange of the MP with the robots of an instruction: scatter, then gather.
//!
//! In: one order per robot. Out: one reply per robot, with its image and the headroom of its rate; or the first
//! cause of what is wrong.

use core::any::TypeId;

use crate::control::guard::RobotView;
use crate::link::Client;
use crate::link::message::{Header, Kind, Message, OrderKind, flag};
use crate::model::fault::{Fault, FaultKind, ProcessId, Role};
use crate::model::list::State;
use crate::model::list::{PayloadType, RobotList, SensorList, SensorsOf};
use crate::model::name::Name;
use crate::model::sensor::EffectorState;
use crate::model::time::Nanos;
use crate::model::wire::{BadWords, Wire};
use crate::observe::witness::{What, Witnesses};
use crate::safety::braking::BrakingLaw;

use super::Mp;

/// One robot as the MP sees it.
pub(crate) struct RobotPort {
    pub name: Name,
    pub kind: TypeId,
    /// The kind's name, for messages.
    pub kind_name: &'static str,
    pub client: Box<dyn Client>,
    pub taken: bool,
    /// Whether its drives know where it is.
    pub(super) homed: bool,
    /// Steps after which the robot must stand when it was told to stop.
    pub(super) stop_steps: u64,
    /// Whether its ECP owed the last answer.
    pub(super) is_silent: bool,
    /// Whether the last instruction handed it over moving.
    pub(super) handed_over: bool,
    /// The type of its orders.
    pub(super) payload: PayloadType,
    pub(super) order: Message,
    pub(super) reply: Message,
}

impl RobotPort {
    pub fn new(
        name: Name,
        (kind, kind_name): (TypeId, &'static str),
        client: Box<dyn Client>,
        stop_steps: u64,
        homed: bool,
    ) -> RobotPort {
        let (order, reply) = (Message::empty(), Message::empty());
        let payload = PayloadType::of::<()>();
        RobotPort {
            name,
            kind,
            kind_name,
            client,
            taken: false,
            homed,
            stop_steps,
            is_silent: false,
            handed_over: false,
            payload,
            order,
            reply,
        }
    }

    /// Takes the answer to the last order, if it is there. One to an order that was given up is none to this one.
    fn receives_answer(&mut self) -> bool {
        let to = |header: &Header| (header.epoch, header.step);
        self.client.receive(&mut self.reply) && to(&self.reply.header) == to(&self.order.header)
    }

    /// What its EDP reported in the last exchange, if it was asked.
    pub(super) fn view(&self) -> Option<RobotView> {
        let words = self.reply.is(flag::STATE).then(|| self.reply.words())?;
        let (measured, demanded) = words.split_at_checked(EffectorState::LEN)?;
        let state = |words: &[u64]| EffectorState::get(words).ok();
        Some(RobotView { name: self.name, measured: state(measured)?, demanded: state(demanded)? })
    }

    /// Shows the order that it was sent.
    fn show_order(&self, kind: OrderKind, witnesses: &Witnesses, now: Nanos) {
        let (robot, PayloadType { name: payload, shape, .. }) = (self.name, self.payload);
        let (step, instruction) = (self.order.header.step, self.order.header.instruction);
        witnesses.show(
            now,
            &What::Order { robot, step, instruction, kind, payload, shape },
            self.order.words(),
        );
    }

    pub(super) fn process(&self) -> ProcessId {
        ProcessId::new(Role::Ecp, self.name)
    }
}

/// What is said of an ECP that does not answer.
pub(super) const SILENT: &str = "no answer from the ECP: its program computes or waits elsewhere";

/// What the robots of an exchange bound: those that an instruction does not name, nothing.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Bounds {
    Rate,
    Nothing,
}

impl Mp<'_> {
    /// Scatter and gather: sends every robot its order, then collects every reply. Where the guard is to look, the other
    /// robots are asked for their states after that.
    pub(super) fn exchange(&mut self, indices: &[usize], kind: OrderKind, flags: u32) -> Result<(), Fault> {
        let looks = !matches!(kind, OrderKind::Stop | OrderKind::Reset)
            && self.protective.is_none()
            && self.guard.as_ref().is_some_and(|guard| guard.is_due(self.clock.step()));
        if !looks {
            return self.scatter_and_gather(indices, kind, flags, Bounds::Rate);
        }
        self.scatter_and_gather(indices, kind, flags | flag::WANT_STATE, Bounds::Rate)?;
        for other in 0..self.robots.len() {
            // One whose drives still look for their marks has no state to tell.
            if !indices.contains(&other) && !self.robots[other].handed_over {
                self.scatter_and_gather(&[other], OrderKind::Query, flag::WANT_STATE, Bounds::Nothing)?;
            }
        }
        self.let_guard_look();
        Ok(())
    }

    fn scatter_and_gather(
        &mut self,
        indices: &[usize],
        kind: OrderKind,
        flags: u32,
        bounds: Bounds,
    ) -> Result<(), Fault> {
        self.clock.spend();
        let flags = if self.clock.is_suspended() { flags | flag::SUSPENDED } else { flags };
        for &index in indices {
            let robot = &mut self.robots[index];
            let header = &mut robot.order.header;
            (header.kind, header.flags, header.step, header.instruction) =
                (Kind::Order(kind), flags, self.clock.step(), self.ordinal);
            (header.dt, header.duration, header.epoch, header.law) =
                (self.clock.dt(), self.clock.duration(), self.epoch, self.law);
            if kind != OrderKind::Step {
                header.len = 0;
            }
            robot.client.send(&robot.order);
            robot.show_order(kind, &self.witnesses, self.host.waiter.now());
        }
        let waiting = self.sensing.patience.begin(self.host.waiter);
        let mut first: Option<Fault> = None;
        let (mut law, mut trouble) = (BrakingLaw::UNLIMITED, None);
        for &index in indices {
            let robot = &mut self.robots[index];
            let (mut lost, mut waiting) = (None, waiting);
            robot.is_silent = false;
            while !robot.receives_answer() {
                let goes_on = waiting.goes_on(&*robot.client, self.host.waiter);
                if !goes_on.map_err(|_| Fault::orderly(FaultKind::CellClosed))? {
                    let silent = Fault::new(FaultKind::PeerLost).in_process(robot.process()).text(SILENT);
                    lost = Some(silent.at_step(self.clock.step()));
                    robot.is_silent = true;
                    robot.reply.header.flags = flag::STANDSTILL;
                    break;
                }
            }
            let fault = match lost {
                Some(lost) => Some(lost),
                None if robot.reply.header.kind == Kind::Fault => Some(robot.reply.fault()),
                None => {
                    if robot.reply.is(flag::TROUBLE) {
                        trouble = trouble.or(Some(robot.reply.fault()));
                    }
                    if bounds == Bounds::Rate {
                        self.clock.feed.limit(robot.reply.header.headroom);
                        law = law.and(robot.reply.header.law);
                    }
                    None
                }
            };
            if let Some(fault) = fault {
                let earlier = first.as_ref().is_none_or(|first| precedes(&fault, first));
                if earlier {
                    first = Some(fault);
                }
            }
        }
        if bounds == Bounds::Rate {
            self.law = law;
        }
        if let Some(trouble) = trouble {
            self.protect(trouble);
        }
        first.map_or(Ok(()), Err)
    }

    /// Asks the robots that the sensors of a list belong to for their states, where none is known yet: a sensor gets the
    /// state of its robot with its first order, too. Says whether any was asked.
    pub(super) fn learn_states<S: SensorList>(&mut self, sensors: &impl SensorsOf<S>) -> Result<bool, Fault> {
        let mut asked = false;
        for i in 0..S::LEN {
            let unknown = self.sensing.robot_of(sensors, i);
            if let Some(robot) = unknown.filter(|&robot| !self.robots[robot].reply.is(flag::STATE)) {
                self.exchange(&[robot], OrderKind::Query, flag::WANT_STATE)?;
                asked = true;
            }
        }
        Ok(asked)
    }

    pub(super) fn order_readings<S: SensorList>(&mut self, sensors: &impl SensorsOf<S>) {
        let robots = &self.robots;
        self.sensing.order(sensors, self.clock.step(), |robot| {
            let reply = robot.map(|robot| &robots[robot].reply).filter(|reply| reply.is(flag::STATE))?;
            Some(&reply.body[..EffectorState::LEN])
        });
    }

    pub(super) fn read_images<L: RobotList>(&self, indices: &[usize], e: &mut State<L>) -> Result<(), Fault> {
        self.each_image(indices, |i, words| L::read(e, i, words))
    }

    /// The image in the last reply of each robot of a list, where there is one.
    pub(super) fn each_image(
        &self,
        indices: &[usize],
        mut read: impl FnMut(usize, &[u64]) -> Result<(), BadWords>,
    ) -> Result<(), Fault> {
        for (i, robot) in indices.iter().map(|&index| &self.robots[index]).enumerate() {
            if robot.reply.is(flag::STATE) {
                let bad = |_| Fault::new(FaultKind::Message).in_process(robot.process());
                read(i, robot.reply.words()).map_err(bad)?;
            }
        }
        Ok(())
    }
}

/// First cause: the lowest step, then the more severe; equals keep the place in the list.
pub(super) fn precedes(fault: &Fault, other: &Fault) -> bool {
    let key = |fault: &Fault| (fault.step().unwrap_or(u64::MAX), core::cmp::Reverse(fault.class()));
    key(fault) < key(other)
}
