//! One exchange of the MP with the robots of an instruction: scatter, then gather.
//!
//! In: one order per robot. Out: one reply per robot, with its image and the headroom of its rate; or the first
//! cause of what is wrong.

use crate::link::message::{Kind, OrderKind, flag};
use crate::model::fault::{Fault, FaultKind};
use crate::model::list::{SensorList, SensorsOf};
use crate::model::sensor::EffectorState;
use crate::model::wire::Wire;
use crate::safety::braking::BrakingLaw;

use super::{Mp, stops};

/// The message of the fault of an ECP that does not answer.
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
        let moves_on = !matches!(kind, OrderKind::Stop | OrderKind::Reset);
        if !moves_on || !self.stops.guard_is_due(self.clock.step()) {
            return self.scatter_and_gather(indices, kind, flags, Bounds::Rate);
        }
        self.scatter_and_gather(indices, kind, flags | flag::WANT_STATE, Bounds::Rate)?;
        for other in 0..self.robots.len() {
            // One whose drives still look for their marks has no state to tell.
            if !indices.contains(&other) && !self.robots[other].handed_over {
                self.scatter_and_gather(&[other], OrderKind::Query, flag::WANT_STATE, Bounds::Nothing)?;
            }
        }
        self.stops.let_guard_look(&self.robots, self.clock.step());
        Ok(())
    }

    /// Asks a robot for its state. Nothing moves, no guard looks, and no step is taken for it: programs begin as they would
    /// without.
    pub(super) fn ask(&mut self, index: usize) -> Result<(), Fault> {
        let is_spent = self.clock.is_spent();
        self.scatter_and_gather(&[index], OrderKind::Query, flag::WANT_STATE, Bounds::Nothing)?;
        if !is_spent {
            self.keep_unless_late();
        }
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
        let instruction = self.robots.ordinal;
        let epoch = self.robots.epoch;
        let law = self.robots.law;
        for &index in indices {
            let robot = &mut self.robots[index];
            let header = &mut robot.order.header;
            header.kind = Kind::Order(kind);
            header.flags = flags;
            header.step = self.clock.step();
            header.instruction = instruction;
            header.dt = self.clock.dt();
            header.duration = self.clock.duration();
            header.epoch = epoch;
            header.law = law;
            if kind != OrderKind::Step {
                header.len = 0;
            }
            robot.client.send(&robot.order);
            robot.show_order(kind, &self.witnesses, self.host.waiter.now());
        }
        self.await_answers(indices)?;
        let mut first: Option<Fault> = None;
        let mut law = BrakingLaw::UNLIMITED;
        let mut trouble = None;
        for &index in indices {
            let robot = &self.robots[index];
            let fault = match robot.reply.header.kind {
                _ if robot.is_silent => {
                    let silent = Fault::new(FaultKind::PeerLost).in_process(robot.process()).text(SILENT);
                    Some(silent.at_step(self.clock.step()))
                }
                Kind::Fault => Some(robot.reply.fault()),
                Kind::Reply | Kind::Order(_) | Kind::Request(_) | Kind::Command | Kind::Read => {
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
                let earlier = first.as_ref().is_none_or(|first| stops::precedes(&fault, first));
                if earlier {
                    first = Some(fault);
                }
            }
        }
        if bounds == Bounds::Rate {
            self.robots.law = law;
        }
        if let Some(trouble) = trouble {
            self.stops.protect(trouble, self.clock.step());
        }
        first.map_or(Ok(()), Err)
    }

    /// Waits for the answers of robots that were sent their orders, or until it is too late for them.
    ///
    /// The last one is waited for first: mostly the others have answered by then, and the MP wakes once in a step.
    fn await_answers(&mut self, indices: &[usize]) -> Result<(), Fault> {
        let waiting = self.sensing.patience.begin(self.host.waiter);
        for &index in indices.iter().rev() {
            let robot = &mut self.robots[index];
            let mut waiting = waiting;
            robot.is_silent = false;
            while !robot.receives_answer() {
                let goes_on = waiting.goes_on(&*robot.client, self.host.waiter);
                if !goes_on.map_err(|_| Fault::orderly(FaultKind::CellClosed))? {
                    robot.is_silent = true;
                    robot.reply.header.flags = flag::STANDSTILL;
                    break;
                }
            }
        }
        Ok(())
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
}
