//! MP: the master process, the coordinator of all robots.
//!
//! In: the ECPs' replies and its virtual sensors. Out: orders, one per robot of the instruction and step. The
//! MP alone paces the cell: its steps begin at multiples of the step, a late one skips indices, and the path
//! time of every step is what the operator's rate leaves of it.

use core::any::TypeId;
use core::time::Duration;

use crate::ecp::MAX_REFUSALS;
use crate::fault::{Fault, FaultKind, FaultWords, ProcessId, Role};
use crate::feed::Feed;
use crate::generator::{Condition, Generator};
use crate::image::{Reading, RobotImage, Sensor, State};
use crate::link::{Client, Nanos, Waiter};
use crate::list::{
    PayloadType, RobotHandle, RobotList, Robots, RobotsOf, SensorHandle, SensorList, SensorsOf,
};
use crate::message::{Kind, Message, flag};
use crate::name::Name;
use crate::operator::Operator;
use crate::payload::{Nudge, Order};
use crate::robot::Robot;
use crate::sensing::Sensing;
use crate::step::{Step, Tick};
use crate::vsp::EffectorState;
use crate::wire::{BadWords, Wire};

/// One robot as the MP sees it.
pub(crate) struct RobotPort {
    pub name: Name,
    pub kind: TypeId,
    pub client: Box<dyn Client>,
    pub taken: bool,
    /// Whether the last instruction handed it over moving.
    handed_over: bool,
    order: Message,
    reply: Message,
}

impl RobotPort {
    pub fn new(name: Name, kind: TypeId, client: Box<dyn Client>) -> RobotPort {
        let (order, reply) = (Message::new(Kind::Query), Message::new(Kind::Reply));
        RobotPort { name, kind, client, taken: false, handed_over: false, order, reply }
    }

    fn process(&self) -> ProcessId {
        ProcessId::new(Role::Ecp, self.name)
    }
}

/// What is called at the start of every step: the cell's index of the step and its operator.
pub(crate) type StepHook = Box<dyn FnMut(u64, &Operator)>;

/// The master process: what the coordinating program is given.
pub struct Mp {
    waiter: Box<dyn Waiter>,
    robots: Vec<RobotPort>,
    sensing: Sensing,
    operator: Operator,
    hook: Option<StepHook>,
    period: Nanos,
    /// Time into a step after which its demands would come too late for the EDPs' ticks \[ns\].
    grace: Nanos,
    /// Index of the step that has begun, and whether an exchange took place in it.
    step: u64,
    used: bool,
    duration: f64,
    dt: f64,
    feed: Feed,
    ordinal: u32,
    latched: Option<Fault>,
    refusals: u32,
}

impl Mp {
    pub(crate) fn new(
        waiter: Box<dyn Waiter>,
        robots: Vec<RobotPort>,
        sensing: Sensing,
        operator: Operator,
        hook: Option<StepHook>,
        (step, grace): (Duration, Nanos),
        rate_change: f64,
    ) -> Mp {
        let duration = step.as_secs_f64();
        Mp {
            waiter,
            robots,
            sensing,
            operator,
            hook,
            period: step.as_nanos() as Nanos,
            grace,
            step: 0,
            used: true,
            duration,
            dt: duration,
            feed: Feed::new(rate_change),
            ordinal: 0,
            latched: None,
            refusals: 0,
        }
    }

    /// The handle of a robot. Each robot has one: pass it on.
    ///
    /// # Errors
    /// `Config` when the cell has no robot of that name and kind, or when its handle is taken.
    pub fn robot<R: Robot>(&mut self, name: &str) -> Result<RobotHandle<R>, Fault> {
        let config = |text: &str| Fault::new(FaultKind::Config).in_process(ProcessId::MP).text(text);
        let names: Vec<_> = self.robots.iter().map(|robot| robot.name.to_string()).collect();
        let Some(index) = self.robots.iter().position(|robot| robot.name.as_str() == name) else {
            return Err(config(&format!("the cell has no robot `{name}`; it has: {}", names.join(", "))));
        };
        let port = &mut self.robots[index];
        if port.kind != TypeId::of::<R>() {
            return Err(config(&format!("robot `{name}` is of another kind than {}", R::KIND)));
        }
        if core::mem::replace(&mut port.taken, true) {
            return Err(config(&format!("robot `{name}` has a handle already: pass that one on")));
        }
        Ok(RobotHandle { index, name: port.name, image: RobotImage::unknown() })
    }

    /// The handle of a virtual sensor of the MP, in its default configuration.
    ///
    /// # Errors
    /// `Config` when the cell gives the MP no sensor of that name and kind, or when its handle is taken.
    pub fn sensor<S: Sensor>(&mut self, name: &str) -> Result<SensorHandle<S>, Fault>
    where
        S::Configuration: Default,
    {
        self.sensing
            .handle(name, S::Configuration::default())
            .map_err(|fault| fault.in_process(ProcessId::MP))
    }

    /// Index of the step that has begun, counted since the cell started.
    #[must_use]
    pub const fn step(&self) -> u64 {
        self.step
    }

    /// **Move**: generates the next states of the robots, step by step, until the generator is done (a motion
    /// without an end of its own: until every ECP has finished); returns the generator.
    ///
    /// Robots that still move then brake: the Move returns at standstill.
    ///
    /// # Errors
    /// The [`Fault`] that ended the motion, at standstill.
    pub fn move_robots<G: Generator>(
        &mut self,
        robots: impl RobotsOf<G::Robots>,
        sensors: impl SensorsOf<G::Sensors>,
        generator: G,
    ) -> Result<G, Fault> {
        self.run(robots, sensors, generator, 0)
    }

    /// **Move** that hands moving robots over: the next Move, which must name them, starts in the very next
    /// step. Anything else than a Move brakes first.
    ///
    /// # Errors
    /// The [`Fault`] that ended the motion, at standstill.
    pub fn blend_robots<G: Generator>(
        &mut self,
        robots: impl RobotsOf<G::Robots>,
        sensors: impl SensorsOf<G::Sensors>,
        generator: G,
    ) -> Result<G, Fault> {
        self.run(robots, sensors, generator, flag::BLEND)
    }

    fn run<G: Generator>(
        &mut self,
        mut robots: impl RobotsOf<G::Robots>,
        mut sensors: impl SensorsOf<G::Sensors>,
        mut generator: G,
        ending: u32,
    ) -> Result<G, Fault> {
        self.check_latch()?;
        let indices = robots.indices();
        let indices = indices.as_ref();
        let mut e = State::new(robots.images());
        let mut v = Reading::new(sensors.images());
        let moved = self.generate(indices, &sensors, &mut generator, &mut e, &mut v);
        let ended = moved.and_then(|()| self.end(indices, Kind::End, ending));
        let outcome = ended.map_err(|fault| self.conclude(fault));
        self.each_image(indices, |i, words| robots.refresh(i, words))?;
        sensors.store(&v);
        outcome.map(|()| generator)
    }

    /// Eq. 6: START, the first step, then a step of the generator and an exchange, until it is done.
    fn generate<G: Generator>(
        &mut self,
        indices: &[usize],
        sensors: &impl SensorsOf<G::Sensors>,
        generator: &mut G,
        e: &mut State<G::Robots>,
        v: &mut Reading<G::Sensors>,
    ) -> Result<(), Fault> {
        let (first_uses, next_uses) = (const { G::CLASS.first_uses() }, const { G::CLASS.next_uses() });
        let wants_state = next_uses.robots || <G::Sensors as SensorList>::LEN > 0;
        let state_flag = if wants_state { flag::WANT_STATE } else { 0 };
        self.begin_step()?;
        let handed_over = self.robots.iter().any(|robot| robot.handed_over);
        self.start(indices, <G::Robots as Robots<G::Language>>::payload)?;
        if first_uses.sensors {
            self.order_readings(sensors);
            self.sensing.collect(sensors, v, &*self.waiter, self.step)?;
            self.used = self.waiter.now() % self.period >= self.grace
                || self.waiter.now() >= (self.step + 1) * self.period;
        }
        let mut step = 0;
        loop {
            self.begin_step()?;
            if step == 0 && !handed_over {
                // No period of this motion can have been skipped.
                self.duration = self.period as f64 * 1e-9;
                self.dt = self.feed.rate() * self.duration;
            }
            if self.operator.is_aborting() && self.dt == 0.0 {
                return self.abort(indices);
            }
            let t = Tick { step, dt: self.dt, duration: self.duration };
            let suspended = self.dt == 0.0;
            let uses = if step == 0 { first_uses } else { next_uses };
            if uses.robots {
                self.read_images::<G::Robots>(indices, e)?;
            }
            let order = Order::new(G::Order::get(&EMPTY).map_err(|_| Fault::new(FaultKind::Message))?);
            let next = if suspended && (step == 0 || !next_uses.tick) {
                None
            } else if step == 0 {
                Some(generator.first_step(&order, e, v, t)?)
            } else {
                Some(generator.next_step(&order, e, v, t)?)
            };
            let demands = match next {
                // An abort that the motion's own end forestalled is an abort: the program must not go on.
                Some(Step::Done) if self.operator.is_aborting() => return self.abort(indices),
                Some(Step::Done) => return Ok(()),
                Some(Step::Next(demands)) => {
                    // Suspended, nothing moves whatever a generator returns, but orders say what they say.
                    step += u64::from(!suspended);
                    Some(demands)
                }
                None => None,
            };
            if let Some(demands) = &demands {
                for (i, &index) in indices.iter().enumerate() {
                    <G::Robots as Robots<G::Language>>::write(demands, i, &mut self.robots[index].order.body);
                    self.robots[index].order.header.len = crate::wire::WORDS as u32;
                }
            }
            if demands.is_none() && step == 0 {
                // Suspended before the first step: there is no order to give yet.
                self.exchange(indices, Kind::Query, flag::WANT_STATE)?;
                if first_uses.sensors {
                    self.order_readings(sensors);
                    self.sensing.collect(sensors, v, &*self.waiter, self.step)?;
                }
                continue;
            }
            self.order_readings(sensors);
            self.exchange(indices, Kind::Step, state_flag)?;
            self.sensing.collect(sensors, v, &*self.waiter, self.step)?;
            if self.finished(indices, const { G::ENDS }, <G::Robots as Robots<G::Language>>::payload)? {
                return Ok(());
            }
        }
    }

    /// Whether every ECP has finished; in a motion with an end of its own or with tight orders none may first.
    fn finished(
        &mut self,
        indices: &[usize],
        ends: bool,
        payload: impl Fn(usize) -> PayloadType,
    ) -> Result<bool, Fault> {
        let all = indices.iter().all(|&index| self.robots[index].reply.is(flag::FINISHED));
        if all && !ends {
            return if self.operator.is_aborting() { self.abort(indices).map(|()| true) } else { Ok(true) };
        }
        for (i, &index) in indices.iter().enumerate() {
            if self.robots[index].reply.is(flag::FINISHED) && payload(i).tight {
                let fault = Fault::new(FaultKind::FinishedEarly).in_process(self.robots[index].process());
                return Err(fault.at_step(self.step));
            }
        }
        Ok(false)
    }

    /// **Wait**: holds until the condition is met; returns it. The robots' images are refreshed in every step.
    ///
    /// # Errors
    /// The [`Fault`] that ended it.
    pub fn wait_until<C: Condition>(
        &mut self,
        robots: impl RobotsOf<C::Robots>,
        sensors: impl SensorsOf<C::Sensors>,
        condition: C,
    ) -> Result<C, Fault> {
        self.wait_until_or(robots, sensors, condition, None)
    }

    /// **Wait** with a time-out of `steps` steps.
    ///
    /// # Errors
    /// `TimedOut` when the condition was not met in that time; the [`Fault`] that ended it otherwise.
    pub fn wait_at_most<C: Condition>(
        &mut self,
        robots: impl RobotsOf<C::Robots>,
        sensors: impl SensorsOf<C::Sensors>,
        condition: C,
        steps: u64,
    ) -> Result<C, Fault> {
        self.wait_until_or(robots, sensors, condition, Some(steps))
    }

    fn wait_until_or<C: Condition>(
        &mut self,
        mut robots: impl RobotsOf<C::Robots>,
        mut sensors: impl SensorsOf<C::Sensors>,
        mut condition: C,
        limit: Option<u64>,
    ) -> Result<C, Fault> {
        self.check_latch()?;
        let indices = robots.indices();
        let indices = indices.as_ref();
        let mut e = State::new(robots.images());
        let mut v = Reading::new(sensors.images());
        let waited = self.wait_step(indices, &sensors, &mut condition, &mut e, &mut v, limit);
        let outcome = waited.map_err(|fault| self.conclude(fault));
        self.each_image(indices, |i, words| robots.refresh(i, words))?;
        sensors.store(&v);
        outcome.map(|()| condition)
    }

    /// Eq. 4: order and collect the readings, refresh the robots' states, until the condition holds.
    fn wait_step<C: Condition>(
        &mut self,
        indices: &[usize],
        sensors: &impl SensorsOf<C::Sensors>,
        condition: &mut C,
        e: &mut State<C::Robots>,
        v: &mut Reading<C::Sensors>,
        limit: Option<u64>,
    ) -> Result<(), Fault> {
        self.settle()?;
        let mut step = 0;
        loop {
            self.begin_step()?;
            if self.operator.is_aborting() {
                self.operator.aborted();
                return Err(Fault::new(FaultKind::Aborted).at_step(self.step));
            }
            self.order_readings(sensors);
            self.exchange(indices, Kind::Query, flag::WANT_STATE)?;
            self.sensing.collect(sensors, v, &*self.waiter, self.step)?;
            self.read_images::<C::Robots>(indices, e)?;
            if self.operator.is_suspended() {
                continue;
            }
            let t = Tick { step, dt: self.dt, duration: self.duration };
            let order = Order::new(C::Order::get(&EMPTY).map_err(|_| Fault::new(FaultKind::Message))?);
            if condition.is_met(&order, e, v, t)? {
                return Ok(());
            }
            step += 1;
            if let Some(limit) = limit.filter(|&limit| step > limit) {
                let fault = Fault::new(FaultKind::TimedOut).at_step(self.step);
                return Err(fault.exceeds(step as f64, limit as f64, "step"));
            }
        }
    }

    /// The nudging MP: one instruction of a constant order to all robots, until every ECP has finished.
    pub(crate) fn nudge(&mut self) -> Result<(), Fault> {
        let indices: Vec<_> = (0..self.robots.len()).collect();
        let nudged = self.nudge_all(&indices).and_then(|()| self.end(&indices, Kind::End, 0));
        nudged.map_err(|fault| self.conclude(fault))
    }

    fn nudge_all(&mut self, indices: &[usize]) -> Result<(), Fault> {
        let payload = PayloadType::of::<Nudge>();
        self.begin_step()?;
        self.start(indices, |_| payload)?;
        loop {
            self.begin_step()?;
            if self.operator.is_aborting() && self.dt == 0.0 {
                return self.abort(indices);
            }
            for &index in indices {
                self.robots[index].order.header.len = 0;
            }
            self.exchange(indices, Kind::Step, 0)?;
            if self.finished(indices, false, |_| payload)? {
                return Ok(());
            }
        }
    }

    /// Begins a step, unless one has begun that no exchange has used.
    fn begin_step(&mut self) -> Result<(), Fault> {
        if !self.used {
            return Ok(());
        }
        let now = self.waiter.now();
        let mut next = (self.step + 1) * self.period;
        if now >= next && now % self.period >= self.grace {
            // Too late for this step as well.
            next = now - now % self.period + self.period;
        }
        while self.waiter.now() < next {
            self.waiter.wait(Some(next)).map_err(|_| Fault::new(FaultKind::CellClosed))?;
        }
        let step = self.waiter.now() / self.period;
        let periods = step - self.step;
        (self.step, self.used) = (step, false);
        self.duration = periods as f64 * self.period as f64 * 1e-9;
        // A hook that panics is not called again by the stop that follows.
        if let Some(mut hook) = self.hook.take() {
            hook(self.step, &self.operator);
            self.hook = Some(hook);
        }
        self.dt = self.feed.advance(self.operator.wanted_rate(), self.duration) * self.duration;
        Ok(())
    }

    /// Opens an instruction: every robot acknowledges the type of its orders and reports a fresh state, or
    /// none moves.
    fn start(&mut self, indices: &[usize], payload: impl Fn(usize) -> PayloadType) -> Result<(), Fault> {
        self.ordinal += 1;
        let left_out = |(index, robot): &(usize, &RobotPort)| robot.handed_over && !indices.contains(index);
        if let Some((_, robot)) = self.robots.iter().enumerate().find(left_out) {
            let text =
                format!("`{}` was handed over moving: the Move after a blend must name it", robot.name);
            return Err(Fault::thrown(&text));
        }
        if !self.take_handed_over() {
            self.feed.reset(self.operator.wanted_rate());
            self.dt = self.feed.rate() * self.duration;
        }
        for (i, &index) in indices.iter().enumerate() {
            let robot = &mut self.robots[index];
            robot.order.header.payload = payload(i).id;
            robot.order.header.len = 0;
        }
        let started = self.exchange(indices, Kind::Start, flag::WANT_STATE).map_err(|fault| {
            let ordered = indices
                .iter()
                .enumerate()
                .find(|(_, index)| fault.robot() == Some(self.robots[**index].name));
            match ordered {
                Some((i, _)) if fault.kind() == FaultKind::PayloadMismatch => {
                    let text = format!("{}, the MP orders `{}`", fault.message(), payload(i).name);
                    fault.text(&text)
                }
                _ => fault,
            }
        });
        // The first orders go out in the same step.
        self.used = false;
        started
    }

    /// Ends an instruction: repeated until every ECP has left it, at standstill.
    fn end(&mut self, indices: &[usize], kind: Kind, ending: u32) -> Result<(), Fault> {
        if ending == flag::BLEND {
            // One END in the step that the next motion starts in; its START comes in the same step.
            self.begin_step()?;
            self.exchange(indices, kind, flag::WANT_STATE | flag::BLEND)?;
            self.used = false;
            if self.have_ended(indices) {
                for &index in indices {
                    self.robots[index].handed_over = true;
                }
                return Ok(());
            }
            // One of them is in its braking tail: then all brake, from this step on.
        }
        loop {
            self.begin_step()?;
            self.exchange(indices, kind, flag::WANT_STATE)?;
            if self.have_ended(indices) {
                // Nothing moved in this step: the next instruction may begin in it.
                self.used = false;
                return Ok(());
            }
        }
    }

    fn have_ended(&self, indices: &[usize]) -> bool {
        indices.iter().all(|&index| self.robots[index].reply.is(flag::ENDED))
    }

    /// Whether robots have been handed over moving; from now on they are in somebody's hands.
    fn take_handed_over(&mut self) -> bool {
        let taken = |any, robot: &mut RobotPort| core::mem::take(&mut robot.handed_over) | any;
        self.robots.iter_mut().fold(false, taken)
    }

    /// The operator's abort, at standstill on the path.
    fn abort(&mut self, indices: &[usize]) -> Result<(), Fault> {
        self.operator.aborted();
        let fault = Fault::new(FaultKind::Aborted).at_step(self.step);
        self.end(indices, Kind::Abort, 0)?;
        Err(fault)
    }

    /// Robots that a blend left moving come to a standstill.
    fn settle(&mut self) -> Result<(), Fault> {
        if self.take_handed_over() {
            let indices: Vec<_> = (0..self.robots.len()).collect();
            loop {
                self.begin_step()?;
                self.exchange(&indices, Kind::Brake, flag::WANT_STATE)?;
                if indices.iter().all(|&index| self.robots[index].reply.is(flag::STANDSTILL)) {
                    return Ok(());
                }
            }
        }
        Ok(())
    }

    /// Scatter and gather: sends every robot its order, then collects every reply.
    fn exchange(&mut self, indices: &[usize], kind: Kind, flags: u32) -> Result<(), Fault> {
        self.used = true;
        for &index in indices {
            let robot = &mut self.robots[index];
            let header = &mut robot.order.header;
            (header.kind, header.flags, header.step, header.instruction) =
                (kind, flags, self.step, self.ordinal);
            (header.dt, header.duration) = (self.dt, self.duration);
            if kind != Kind::Step {
                header.len = 0;
            }
            robot.client.send(&robot.order);
        }
        let deadline = self.waiter.now() + self.sensing.patience;
        let mut first: Option<Fault> = None;
        for &index in indices {
            let robot = &mut self.robots[index];
            let mut lost = None;
            while !robot.client.receive(&mut robot.reply) {
                self.waiter.wait(Some(deadline)).map_err(|_| Fault::new(FaultKind::CellClosed))?;
                if self.waiter.now() >= deadline {
                    let text = "no answer from the ECP: its program computes or waits elsewhere";
                    lost = Some(
                        Fault::new(FaultKind::PeerLost)
                            .in_process(robot.process())
                            .text(text)
                            .at_step(self.step),
                    );
                    robot.reply.header.flags = flag::STANDSTILL;
                    break;
                }
            }
            let fault = match lost {
                Some(lost) => Some(lost),
                None if robot.reply.header.kind == Kind::Fault => Some(
                    FaultWords::get(robot.reply.words())
                        .map_or_else(|_| Fault::new(FaultKind::Message), Fault::from),
                ),
                None => {
                    self.feed.limit(robot.reply.header.headroom);
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
        match first {
            Some(fault) => Err(fault),
            None => Ok(()),
        }
    }

    fn order_readings<S: SensorList>(&mut self, sensors: &impl SensorsOf<S>) {
        let robots = &self.robots;
        self.sensing.order(sensors, self.step, |robot| {
            let reply = robot.map(|robot| &robots[robot].reply).filter(|reply| reply.is(flag::STATE))?;
            Some(&reply.body[..EffectorState::LEN])
        });
    }

    fn read_images<L: RobotList>(&self, indices: &[usize], e: &mut State<L>) -> Result<(), Fault> {
        self.each_image(indices, |i, words| L::read(e, i, words))
    }

    /// The image in the last reply of each robot of a list, where there is one.
    fn each_image(
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

    /// A fault in an instruction: unless it ended at standstill by itself, all robots stop; it is latched.
    fn conclude(&mut self, fault: Fault) -> Fault {
        let fault = fault.in_process(ProcessId::MP).at_step(self.step);
        match fault.kind() {
            FaultKind::CellClosed | FaultKind::Aborted => return fault,
            // A Wait that was too long: nothing moves and nothing is wrong with the cell.
            FaultKind::TimedOut if fault.process() == Some(ProcessId::MP) => return fault,
            _ => {}
        }
        self.stop(fault)
    }

    /// Stops every robot of the cell and latches the first cause.
    pub(crate) fn stop(&mut self, fault: Fault) -> Fault {
        let fault = self.latched.get_or_insert(fault).clone();
        self.take_handed_over();
        let all: Vec<_> = (0..self.robots.len()).collect();
        loop {
            if self.begin_step().is_err() {
                return fault;
            }
            // Every reply is a fault now; what counts is that the robots stand.
            let answered = self.exchange(&all, Kind::Stop, 0);
            if answered.is_err_and(|error| error.kind() == FaultKind::CellClosed) {
                return fault;
            }
            if all.iter().all(|&index| self.robots[index].reply.is(flag::STANDSTILL)) {
                return fault;
            }
        }
    }

    fn check_latch(&mut self) -> Result<(), Fault> {
        let Some(fault) = &self.latched else { return Ok(()) };
        let fault = fault.clone();
        self.refusals += 1;
        if self.refusals > MAX_REFUSALS {
            // Ends a program that loops over refused instructions, through the process's own boundary.
            self.refusals = 0;
            std::panic::resume_unwind(Box::new("the program ignores a latched fault"));
        }
        // A refused call takes a step: a program that ignores the fault cannot stop the cell's time.
        self.used = true;
        self.begin_step()?;
        Err(fault)
    }

    /// Runs the coordinating program. A panic in it stops the robots as any fault does.
    pub(crate) fn run_program(
        &mut self,
        program: impl FnOnce(&mut Mp) -> Result<(), Fault>,
    ) -> Result<(), Fault> {
        let run = std::panic::AssertUnwindSafe(|| program(self));
        match std::panic::catch_unwind(run) {
            Ok(outcome) => {
                let settled = self.settle().map_err(|fault| self.stop(fault));
                // A program that swallows a latched fault does not undo it.
                let latched = self.latched.clone().map_or(Ok(()), Err);
                outcome.map_err(|fault| fault.in_process(ProcessId::MP)).and(settled).and(latched)
            }
            Err(panic) => {
                let fault = crate::fault::panicked(&*panic).in_process(ProcessId::MP).at_step(self.step);
                Err(self.stop(fault))
            }
        }
    }
}

/// First cause: the lowest step, then the more severe; equals keep the place in the list.
fn precedes(fault: &Fault, other: &Fault) -> bool {
    let key = |fault: &Fault| (fault.step().unwrap_or(u64::MAX), core::cmp::Reverse(fault.class()));
    key(fault) < key(other)
}

const EMPTY: [u64; crate::wire::WORDS] = [0; crate::wire::WORDS];
