//! One exchange of the MP with the robots of an instruction: scatter, then gather.
//!
//! In: one order per robot. Out: one reply per robot, with its image and the margin of its rate; or the first
//! cause of what is wrong.

use crate::control::sensing::SensorsRead;
use crate::control::state_words::StateWords;
use crate::link::message::{Kind, OrderKind, flag};
use crate::model::fault::{Fault, FaultKind};
use crate::safety::braking::BrakingLaw;

use super::background::Background;
use super::robots::Gathered;
use super::{Mp, stops};

impl Mp<'_> {
    /// Scatter and gather: sends every robot its order, then collects every reply; those that move in the background have
    /// their orders of the step with the first exchange in it. Where the guard is to look, the other robots are asked for
    /// their states after that.
    pub(super) fn exchange(&mut self, indices: &[usize], kind: OrderKind, flags: u32) -> Result<(), Fault> {
        let moves_on = !matches!(kind, OrderKind::Stop | OrderKind::Reset);
        if !moves_on || !self.stops.guard_is_due(self.clock.step()) {
            return self.scatter_and_gather(indices, kind, flags);
        }
        self.scatter_and_gather(indices, kind, flags | flag::WANT_STATE)?;
        for other in 0..self.robots.len() {
            // One whose drives still look for their marks has no state to tell; one in the background has told it.
            if !indices.contains(&other) && !self.robots[other].handed_over && !self.background.has(other) {
                self.query(other)?;
            }
        }
        self.stops.let_guard_look(&self.robots, self.clock.step());
        Ok(())
    }

    /// Asks a robot for its state. Nothing moves, no guard looks, and no step is taken for it: programs begin as they would
    /// without.
    pub(super) fn ask(&mut self, index: usize) -> Result<(), Fault> {
        let is_spent = self.clock.is_spent();
        self.query(index)?;
        if !is_spent {
            self.keep_unless_late();
        }
        Ok(())
    }

    /// Asks a robot that no instruction names for its state: it bounds nothing.
    fn query(&mut self, index: usize) -> Result<(), Fault> {
        self.clock.spend();
        self.send(index, OrderKind::Query, flag::WANT_STATE, self.robots.law);
        self.await_answers(&[index])?;
        let mut gathered = Gathered::NOTHING;
        self.look(index, &mut gathered);
        self.check(gathered)
    }

    fn scatter_and_gather(&mut self, indices: &[usize], kind: OrderKind, flags: u32) -> Result<(), Fault> {
        let mut beside = self.background.lend(kind, flags);
        let outcome = self.exchange_beside(&mut beside, indices, kind, flags);
        self.background.take_back(beside);
        outcome
    }

    fn exchange_beside(
        &mut self,
        beside: &mut Background,
        indices: &[usize],
        kind: OrderKind,
        flags: u32,
    ) -> Result<(), Fault> {
        self.clock.spend();
        beside.send(self)?;
        let law = self.robots.law;
        let mut gathered = Gathered::NOTHING;
        let in_background = |mp: &Mp<'_>, index| beside.has(index) || mp.background.has(index);
        if kind == OrderKind::Query && indices.iter().any(|&index| in_background(self, index)) {
            // A Wait that names a robot in the background: that one tells its state with every order.
            for &index in indices {
                if !in_background(self, index) {
                    self.send(index, kind, flags, law);
                    self.await_answers(&[index])?;
                    self.gather(&[index], &mut gathered);
                }
            }
        } else {
            for &index in indices {
                self.send(index, kind, flags, law);
            }
            self.await_answers(indices)?;
            self.gather(indices, &mut gathered);
        }
        self.robots.law = gathered.law;
        beside.collect(self, &mut gathered)?;
        self.check(gathered)
    }

    /// Sends a robot an order of this step.
    pub(super) fn send(&mut self, index: usize, kind: OrderKind, flags: u32, law: BrakingLaw) {
        let flags = if self.clock.is_suspended() { flags | flag::SUSPENDED } else { flags };
        let flags = if self.is_reduced() { flags | flag::REDUCED } else { flags };
        let ordinal = self.robots.ordinal;
        let epoch = self.robots.epoch;
        let jog = if kind == OrderKind::Step { self.jogging.of(index) } else { None };
        let robot = &mut self.robots[index];
        robot.asked = !robot.is_left_out_of(kind);
        if !robot.asked {
            return;
        }
        let header = &mut robot.order.header;
        header.kind = Kind::Order(kind);
        header.flags = flags;
        header.step = self.clock.step();
        header.instruction = match kind {
            OrderKind::Start | OrderKind::Step | OrderKind::End | OrderKind::Abort => robot.instruction,
            OrderKind::Query | OrderKind::Brake | OrderKind::Stop | OrderKind::Reset => ordinal,
        };
        header.dt = self.clock.dt();
        header.duration = self.clock.duration();
        header.epoch = epoch;
        header.law = law;
        if kind != OrderKind::Step {
            header.len = 0;
        }
        match jog {
            None => robot.client.send(&robot.order),
            Some(jog) => robot.send_with(jog),
        }
        robot.show_order(kind, &self.step_observers, || self.host.waiter.now());
    }

    /// What the replies of robots say that an instruction, or a motion in the background, names: they bound the rate of path
    /// time.
    pub(super) fn gather(&mut self, indices: &[usize], gathered: &mut Gathered) {
        for &index in indices {
            if self.look(index, gathered) {
                let header = &self.robots[index].reply.header;
                self.clock.feed.limit(header.rate_margin);
                gathered.law = gathered.law.and(header.law);
            }
        }
    }

    /// What the reply of a robot says; whether it is no fault.
    fn look(&self, index: usize, gathered: &mut Gathered) -> bool {
        let robot = &self.robots[index];
        let fault = match robot.reply.header.kind {
            _ if robot.is_silent => {
                let silent = Fault::new(FaultKind::PeerLost).in_process(robot.process()).text(robot.silent());
                silent.at_step(self.clock.step())
            }
            Kind::Fault => robot.reply.fault(),
            Kind::Reply | Kind::Order(_) | Kind::Request(_) | Kind::Command | Kind::Read => {
                if gathered.trouble.is_none() && robot.reply.is(flag::TROUBLE) {
                    gathered.trouble = Some(robot.reply.fault());
                }
                return true;
            }
        };
        let earlier = gathered.first.as_ref().is_none_or(|first| stops::precedes(&fault, first));
        if earlier {
            gathered.first = Some(fault);
        }
        false
    }

    /// Begins the stop that a reply asks for.
    ///
    /// # Errors
    /// The first cause of what is wrong.
    fn check(&mut self, gathered: Gathered) -> Result<(), Fault> {
        if let Some(trouble) = gathered.trouble {
            self.stops.protect(trouble, self.clock.step());
        }
        gathered.first.map_or(Ok(()), Err)
    }

    /// Waits for the answers of robots that were sent their orders, or until it is too late for them.
    ///
    /// The last one is waited for first: mostly the others have answered by then, and the MP wakes once in a step. Meanwhile the
    /// MP above, if there is one, gets its answers.
    ///
    /// Of robots that move together, one that has not got its order begins to brake when this wait is over, and the others must be
    /// told in that step.
    pub(super) fn await_answers(&mut self, indices: &[usize]) -> Result<(), Fault> {
        let Mp { robots, upper, host, sensing, clock, .. } = self;
        let mut waiting = sensing.timeout.begin(host.waiter);
        if indices.iter().any(|&index| robots[index].is_together()) {
            waiting = waiting.until(clock.together_until());
        }
        for &index in indices.iter().rev() {
            let robot = &mut robots[index];
            let mut waiting = waiting;
            robot.is_silent = false;
            while robot.asked && !robot.receives_answer() {
                let goes_on = waiting.goes_on(&*robot.client, host.waiter);
                upper.iter_mut().for_each(|upper| upper.serve(host.waiter.now()));
                if !goes_on.map_err(|_| Fault::orderly(FaultKind::CellClosed))? {
                    robot.is_silent = true;
                    robot.reply.header.flags = flag::STANDSTILL;
                    break;
                }
            }
            robot.stand_in_for_cell();
        }
        Ok(())
    }

    /// Asks the robots that the sensors of a list belong to for their states, where none is known yet: a sensor gets the
    /// state of its robot with its first order, too. Says whether any was asked.
    pub(super) fn learn_states(&mut self, sensors: &dyn SensorsRead) -> Result<bool, Fault> {
        let mut asked = false;
        for &place in sensors.places() {
            let unknown = self.sensing.robot_of(place);
            if let Some(robot) = unknown.filter(|&robot| !self.robots[robot].reply.is(flag::STATE)) {
                self.exchange(&[robot], OrderKind::Query, flag::WANT_STATE)?;
                asked = true;
            }
        }
        Ok(asked)
    }

    pub(super) fn order_readings(&mut self, sensors: &dyn SensorsRead) {
        let robots = &self.robots;
        self.sensing.order(sensors, self.clock.step(), &|robot| StateWords::of(&robots[robot?].reply));
    }
}
