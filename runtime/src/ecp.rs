//! ECP: the effector control process, the task for one robot.
//!
//! In: the MP's orders, one per step. Out: demands to the EDP, and in each reply to the MP the robot's image
//! and how fast the rate may change. The MP paces: a step of an ECP begins with an order, and its answer ends
//! it. An order that a generator's end left unused is the next motion's first.

use crate::demand::Demand;
use crate::fault::{Fault, FaultKind, FaultWords, ProcessId};
use crate::feed::{DEFAULT_CHANGE, Feed};
use crate::generator::{Condition, Generator};
use crate::image::{Reading, RobotImage, Sensor, State};
use crate::link::{Client, Nanos, Server, Waiter};
use crate::list::{AnyRobots, Motion, PayloadType, RobotList, SensorHandle, SensorList, SensorsOf};
use crate::message::{Kind, Message, flag};
use crate::payload::{Order, Payload};
use crate::robot::Robot;
use crate::sensing::Sensing;
use crate::step::{Step, Tick};
use crate::vsp::EffectorState;
use crate::wire::Wire;

/// What becomes of a motion that ends while it moves.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Ending {
    /// The braking tail is appended.
    Standstill,
    /// The next motion takes over in the very next step.
    Blend,
}

/// The images that a condition looks at in an ECP: its robot's or none.
#[doc(hidden)]
pub trait LooksAt<R: Robot>: RobotList {
    fn look(image: &RobotImage<R>) -> Self::Images;
}

impl<R: Robot> LooksAt<R> for R {
    fn look(image: &RobotImage<R>) -> RobotImage<R> {
        *image
    }
}

impl<R: Robot> LooksAt<R> for AnyRobots {
    fn look(_: &RobotImage<R>) {}
}

/// An effector control process: what a robot's program is given.
pub struct Ecp<R: Robot> {
    process: ProcessId,
    waiter: Box<dyn Waiter>,
    mp: Box<dyn Server>,
    edp: Box<dyn Client>,
    sensing: Sensing,
    patience: Nanos,
    /// The cell's step, and the time into it after which a demand would come too late for the EDP's ticks \[ns\].
    period: Nanos,
    grace: Nanos,
    /// The MP's order; `open` until it is answered.
    order: Message,
    open: bool,
    /// Scratch for requests to the EDP and answers to the MP, and the EDP's last reply.
    out: Message,
    driver: Message,
    image: RobotImage<R>,
    /// The type of the open instruction's orders.
    instruction: Option<PayloadType>,
    /// Whether the EDP has a demand that moves.
    moving: bool,
    latched: Option<Fault>,
    refusals: u32,
}

/// Refused calls after which a program that ignores a latched fault, or the end of the cell, is ended.
pub(crate) const MAX_REFUSALS: u32 = 10_000;

impl<R: Robot> Ecp<R> {
    pub(crate) fn new(
        process: ProcessId,
        waiter: Box<dyn Waiter>,
        mp: Box<dyn Server>,
        edp: Box<dyn Client>,
        sensing: Sensing,
        (period, grace): (Nanos, Nanos),
    ) -> Self {
        Ecp {
            process,
            waiter,
            mp,
            edp,
            patience: sensing.patience,
            sensing,
            period,
            grace,
            order: Message::new(Kind::Query),
            open: false,
            out: Message::new(Kind::Query),
            driver: Message::new(Kind::Reply),
            image: RobotImage::unknown(),
            instruction: None,
            moving: false,
            latched: None,
            refusals: 0,
        }
    }

    /// The robot's image at the end of the last motion or Wait.
    #[must_use]
    pub const fn image(&self) -> &RobotImage<R> {
        &self.image
    }

    /// The handle of a virtual sensor of this robot, in its default configuration.
    ///
    /// # Errors
    /// `Config` when the cell gives this ECP no sensor of that name and kind, or when its handle is taken.
    pub fn sensor<S: Sensor>(&mut self, name: &str) -> Result<SensorHandle<S>, Fault>
    where
        S::Configuration: Default,
    {
        let process = self.process;
        self.sensing.handle(name, S::Configuration::default()).map_err(|fault| fault.in_process(process))
    }

    /// Does the ECP's part of one instruction of the MP: `program` is run with the first order's value when the
    /// MP starts an instruction of this payload; its return means *finished*.
    ///
    /// With an `enum` payload the program may finish early and then holds until the MP ends the instruction;
    /// with a `struct` payload finishing early is a fault.
    ///
    /// # Errors
    /// What `program` returned, except that an instruction that the MP has ended is no fault. `PayloadMismatch`
    /// when the MP's instruction has orders of another type: then nothing has moved.
    pub fn obey<P: Payload>(
        &mut self,
        program: impl FnOnce(&mut Self, P) -> Result<(), Fault>,
    ) -> Result<(), Fault> {
        self.check_latch()?;
        if self.instruction.is_some() {
            return Err(self.fail(Fault::thrown("obey inside obey: an ECP obeys one instruction at a time")));
        }
        let value = self.await_start::<P>()?;
        self.instruction = Some(PayloadType::of::<P>());
        let outcome = program(self, value);
        let outcome = self.finish(outcome);
        self.instruction = None;
        outcome
    }

    /// Waits for START and the first order.
    fn await_start<P: Payload>(&mut self) -> Result<P, Fault> {
        loop {
            match self.next_order()? {
                Kind::Start => {}
                Kind::Stop => return Err(self.stopped()),
                // The tail of an instruction that has ended here, or of a blend that no Move takes over.
                _ => {
                    self.hold(flag::ENDED | flag::FINISHED)?;
                    continue;
                }
            }
            if self.order.header.payload != P::ID {
                let fault = Fault::new(FaultKind::PayloadMismatch);
                return Err(self.fail(fault.text(&format!("this ECP obeys orders of type `{}`", P::NAME))));
            }
            if let Err(fault) = self.ask_edp(Kind::Query, flag::FIRST | flag::WANT_STATE) {
                return Err(self.fail(fault));
            }
            self.answer(flag::STATE);
            self.refusals = 0;
            match self.next_order()? {
                Kind::Step => {
                    return P::get(self.order.words()).map_err(|_| self.fail(Fault::new(FaultKind::Message)));
                }
                Kind::Stop => return Err(self.stopped()),
                // Ended before its first step: the next START counts.
                _ => self.hold(flag::ENDED | flag::FINISHED)?,
            }
        }
    }

    /// Holds after the program's return until the MP ends the instruction.
    fn finish(&mut self, outcome: Result<(), Fault>) -> Result<(), Fault> {
        let settled = if self.latched.is_none() { self.settle_unless_blending() } else { Ok(()) };
        match outcome.and(settled) {
            Ok(()) => {}
            Err(fault) if fault.kind() == FaultKind::InstructionEnded => {}
            Err(fault) if fault.kind() == FaultKind::Aborted => {
                self.hold(flag::ENDED | flag::FINISHED)?;
                return Err(fault);
            }
            Err(fault) if self.latched.is_some() => return Err(fault),
            Err(fault) => return Err(self.fail(fault)),
        }
        loop {
            match self.next_order()? {
                Kind::End => {
                    self.hold(flag::ENDED | flag::FINISHED)?;
                    return Ok(());
                }
                Kind::Abort => {
                    self.hold(flag::ENDED | flag::FINISHED)?;
                    return Err(Fault::new(FaultKind::Aborted).in_process(self.process));
                }
                Kind::Stop => return Err(self.stopped()),
                _ => self.hold(flag::FINISHED)?,
            }
        }
    }

    /// **Move**: generates the robot's next states, one per step, until the generator is done; returns it.
    ///
    /// A generator that ends while moving gets the braking tail: the Move returns at standstill.
    ///
    /// # Errors
    /// The [`Fault`] that ended the motion, at standstill.
    pub fn move_robot<G>(&mut self, sensors: impl SensorsOf<G::Sensors>, generator: G) -> Result<G, Fault>
    where
        G: Generator<Robots = R, Language = Motion>,
    {
        self.run(sensors, generator, Ending::Standstill)
    }

    /// **Move** that hands a moving robot over: the next Move starts in the very next step, from this one's
    /// last demand and its velocity. Anything else than a Move brakes first.
    ///
    /// # Errors
    /// The [`Fault`] that ended the motion, at standstill.
    pub fn blend_robot<G>(&mut self, sensors: impl SensorsOf<G::Sensors>, generator: G) -> Result<G, Fault>
    where
        G: Generator<Robots = R, Language = Motion>,
    {
        self.run(sensors, generator, Ending::Blend)
    }

    fn run<G>(
        &mut self,
        mut sensors: impl SensorsOf<G::Sensors>,
        mut generator: G,
        ending: Ending,
    ) -> Result<G, Fault>
    where
        G: Generator<Robots = R, Language = Motion>,
    {
        let mut v = Reading::new(sensors.images());
        let end = self.generate(&sensors, &mut generator, &mut v, ending);
        sensors.store(&v);
        end.map(|()| generator)
    }

    fn generate<G>(
        &mut self,
        sensors: &impl SensorsOf<G::Sensors>,
        generator: &mut G,
        v: &mut Reading<G::Sensors>,
        ending: Ending,
    ) -> Result<(), Fault>
    where
        G: Generator<Robots = R, Language = Motion>,
    {
        let (first_uses, next_uses) = (const { G::CLASS.first_uses() }, const { G::CLASS.next_uses() });
        self.check_ready()?;
        self.check_payload::<G::Order>(first_uses.order || next_uses.order)?;
        let mut e = State::<R>::new(self.image);
        let mut order = self.read_order::<G::Order>(false)?;
        let mut step = 0;
        let mut own = Feed::new(DEFAULT_CHANGE);
        let mut flags = flag::FIRST;
        let mut refreshed = false;
        loop {
            let kind = self.next_order()?;
            let ending_now = kind == Kind::End;
            match kind {
                Kind::Stop => return Err(self.stopped()),
                Kind::Abort => {
                    self.settle()?;
                    return Err(Fault::new(FaultKind::Aborted).in_process(self.process));
                }
                // What transmits orders has none to transmit any more; what has no path of its own cannot
                // slow down on it; what is handed over shall not.
                Kind::End if next_uses.order || !next_uses.tick || step == 0 => break,
                Kind::End if self.order.is(flag::BLEND) => break,
                _ => {}
            }
            let (mut dt, mut duration) = (self.order.header.dt, self.order.header.duration);
            if step == 0 && !self.moving && duration > 0.0 {
                // No period of this motion can have been skipped.
                let period = self.period as f64 * 1e-9;
                (dt, duration) = (dt / duration * period, period);
            }
            if ending_now {
                // The MP may be slowing down as well: both bound the change of the one rate that counts.
                own.limit(self.driver.header.headroom);
                let slower = own.clone().advance(0.0, duration);
                if slower == 0.0 {
                    break;
                }
                dt = dt.min(slower * duration);
            }
            own.follow(if duration > 0.0 { dt / duration } else { 0.0 }, duration);
            let uses = if step == 0 { first_uses } else { next_uses };
            if dt == 0.0 {
                // Suspended: the robot holds whatever the generator says, which may only end.
                if step == 0 || !next_uses.tick {
                    self.execute(sensors, v, Kind::Brake, 0, uses.robots)?;
                } else {
                    Demand::<R>::hold().put(&mut self.out.body);
                    self.out.header.dt = dt;
                    self.execute(sensors, v, Kind::Demand, 0, uses.robots)?;
                    (*e) = self.image;
                    let t = Tick { step, dt, duration };
                    match generator.next_step(&order, &e, v, t).map_err(|fault| self.fail(fault))? {
                        Step::Done => break,
                        Step::Next(_) => {}
                    }
                }
                self.answer(self.driver.header.flags & flag::STATE);
                continue;
            }
            if step == 0 && (first_uses.robots || first_uses.sensors) && !refreshed {
                let began = self.waiter.now();
                self.refresh(sensors, v, first_uses.robots)?;
                refreshed = true;
                if self.waiter.now() > began && self.is_late() {
                    self.answer(self.driver.header.flags & flag::STATE);
                    continue;
                }
            }
            if uses.robots {
                *e = self.image;
            }
            if uses.order {
                order = self.read_order(true)?;
            }
            let t = Tick { step, dt, duration };
            let next = if step == 0 {
                generator.first_step(&order, &e, v, t)
            } else {
                generator.next_step(&order, &e, v, t)
            };
            let demand = match next {
                Ok(Step::Next(demand)) => demand,
                Ok(Step::Done) => break,
                Err(fault) => return Err(self.fail(fault)),
            };
            demand.put(&mut self.out.body);
            self.out.header.dt = dt / duration * self.order.header.duration;
            self.moving = true;
            self.execute(sensors, v, Kind::Demand, flags, next_uses.robots)?;
            (step, flags) = (step + 1, 0);
            self.answer(if ending_now { 0 } else { self.driver.header.flags & flag::STATE });
        }
        match ending {
            Ending::Standstill => self.settle_unless_blending(),
            Ending::Blend => Ok(()),
        }
    }

    /// One step of eq. 6: order the readings, send the demand, collect the reply and the readings.
    fn execute<S: SensorList>(
        &mut self,
        sensors: &impl SensorsOf<S>,
        v: &mut Reading<S>,
        kind: Kind,
        flags: u32,
        needs_state: bool,
    ) -> Result<(), Fault> {
        let wanted = if needs_state || S::LEN > 0 { flag::WANT_STATE } else { 0 };
        let step = self.order.header.step;
        let driver = &self.driver;
        let robot = driver.is(flag::STATE).then(|| &driver.body[..EffectorState::LEN]);
        self.sensing.order(sensors, step, |_| robot);
        let reply = self.ask_edp(kind, flags | wanted);
        reply.map_err(|fault| self.fail(fault))?;
        let collected = self.sensing.collect(sensors, v, &*self.waiter, step);
        collected.map_err(|fault| self.fail(fault))
    }

    /// **Wait**: holds until the condition is met; returns it.
    ///
    /// # Errors
    /// The [`Fault`] that ended it.
    pub fn wait_until<C>(&mut self, sensors: impl SensorsOf<C::Sensors>, condition: C) -> Result<C, Fault>
    where
        C: Condition,
        C::Robots: LooksAt<R>,
    {
        self.wait_until_or(sensors, condition, None)
    }

    /// **Wait** with a time-out of `steps` steps.
    ///
    /// # Errors
    /// `TimedOut` when the condition was not met in that time; the [`Fault`] that ended it otherwise.
    pub fn wait_at_most<C>(
        &mut self,
        sensors: impl SensorsOf<C::Sensors>,
        condition: C,
        steps: u64,
    ) -> Result<C, Fault>
    where
        C: Condition,
        C::Robots: LooksAt<R>,
    {
        self.wait_until_or(sensors, condition, Some(steps))
    }

    fn wait_until_or<C>(
        &mut self,
        mut sensors: impl SensorsOf<C::Sensors>,
        mut condition: C,
        limit: Option<u64>,
    ) -> Result<C, Fault>
    where
        C: Condition,
        C::Robots: LooksAt<R>,
    {
        let uses = const { C::CLASS.next };
        self.check_ready()?;
        self.check_payload::<C::Order>(uses.order)?;
        self.settle()?;
        let mut v = Reading::new(sensors.images());
        let mut step = 0;
        let end = loop {
            match self.next_order()? {
                Kind::Stop => return Err(self.stopped()),
                Kind::End => break Err(Fault::new(FaultKind::InstructionEnded).in_process(self.process)),
                Kind::Abort => break Err(Fault::new(FaultKind::Aborted).in_process(self.process)),
                _ => {}
            }
            self.refresh(&sensors, &mut v, uses.robots)?;
            let header = self.order.header;
            // Suspended, a Wait waits on.
            if header.dt > 0.0 || header.duration == 0.0 {
                let order = self.read_order(uses.order)?;
                let e = State::new(C::Robots::look(&self.image));
                let t = Tick { step, dt: header.dt, duration: header.duration };
                match condition.is_met(&order, &e, &v, t) {
                    Ok(true) => break Ok(condition),
                    Ok(false) => {}
                    Err(fault) => return Err(self.fail(fault)),
                }
                step += 1;
                if limit.is_some_and(|limit| step > limit) {
                    let fault = Fault::new(FaultKind::TimedOut).in_process(self.process).at_step(header.step);
                    break Err(fault.exceeds(step as f64, limit.unwrap_or(0) as f64, "step"));
                }
            }
            self.answer(self.driver.header.flags & flag::STATE);
        };
        sensors.store(&v);
        end
    }

    /// The next order of the MP, or the one that is still open. Queries are answered on the way.
    fn next_order(&mut self) -> Result<Kind, Fault> {
        while !self.open {
            while !self.mp.receive(&mut self.order) {
                if self.waiter.wait(None).is_err() {
                    self.refuse();
                    return Err(Fault::new(FaultKind::CellClosed).in_process(self.process));
                }
            }
            self.open = true;
            if self.order.header.kind == Kind::Query {
                self.hold(0)?;
            }
        }
        Ok(self.order.header.kind)
    }

    /// Answers the open order. With `flag::STATE` the image of the EDP's last reply goes with it.
    fn answer(&mut self, flags: u32) {
        let (out, driver) = (&mut self.out, &self.driver);
        out.header = self.order.header;
        out.header.kind = Kind::Reply;
        out.header.flags = flags | driver.header.flags & flag::STANDSTILL;
        out.header.headroom = driver.header.headroom;
        out.header.len = 0;
        if flags & flag::STATE != 0 {
            out.header.len = driver.header.len;
            out.body[..driver.words().len()].copy_from_slice(driver.words());
        }
        self.mp.reply(out);
        self.open = false;
    }

    fn answer_fault(&mut self, fault: &Fault) {
        self.out.header = self.order.header;
        self.out.header.kind = Kind::Fault;
        self.out.header.flags = self.driver.header.flags & flag::STANDSTILL;
        self.out.header.len = FaultWords::LEN as u32;
        FaultWords::from(fault).put(&mut self.out.body);
        self.mp.reply(&self.out);
        self.open = false;
    }

    /// One exchange with the EDP; the body of a demand has been written.
    fn ask_edp(&mut self, kind: Kind, flags: u32) -> Result<(), Fault> {
        let header = &mut self.out.header;
        (header.kind, header.step, header.duration) =
            (kind, self.order.header.step, self.order.header.duration);
        // The MP's wish is this process's wish.
        header.flags = flags | self.order.header.flags & flag::WANT_STATE;
        header.len = if kind == Kind::Demand { <Demand<R> as Wire>::LEN as u32 } else { 0 };
        self.edp.send(&self.out);
        let deadline = self.waiter.now() + self.patience;
        while !self.edp.receive(&mut self.driver) {
            let closed = |_| Fault::new(FaultKind::CellClosed).in_process(self.process);
            self.waiter.wait(Some(deadline)).map_err(closed)?;
            if self.waiter.now() >= deadline {
                return Err(Fault::new(FaultKind::PeerLost).text("no answer from the EDP"));
            }
        }
        if self.driver.header.kind == Kind::Fault {
            let words = FaultWords::get(self.driver.words()).map_err(|_| Fault::new(FaultKind::Message))?;
            return Err(Fault::from(words));
        }
        if self.driver.is(flag::STATE) {
            self.image = RobotImage::get(self.driver.words()).map_err(|_| Fault::new(FaultKind::Message))?;
        }
        Ok(())
    }

    /// A Wait-style exchange: readings and the robot's state, while the demand does not change.
    fn refresh<S: SensorList>(
        &mut self,
        sensors: &impl SensorsOf<S>,
        v: &mut Reading<S>,
        needs_state: bool,
    ) -> Result<(), Fault> {
        if needs_state || S::LEN > 0 || self.order.is(flag::WANT_STATE) {
            let fresh = self.ask_edp(Kind::Query, flag::WANT_STATE);
            fresh.map_err(|fault| self.fail(fault))?;
        }
        let step = self.order.header.step;
        let driver = &self.driver;
        let robot = driver.is(flag::STATE).then(|| &driver.body[..EffectorState::LEN]);
        self.sensing.order(sensors, step, |_| robot);
        let collected = self.sensing.collect(sensors, v, &*self.waiter, step);
        collected.map_err(|fault| self.fail(fault))
    }

    /// Answers a step in which the robot stands. One that a blend left moving brakes, unless this very order
    /// hands it over; it has not left the instruction before it stands.
    fn hold(&mut self, mut flags: u32) -> Result<(), Fault> {
        let handed_over = self.order.header.kind == Kind::End && self.order.is(flag::BLEND);
        let brakes = self.moving && !handed_over;
        let wants = brakes || self.order.is(flag::WANT_STATE) || flags & flag::ENDED != 0;
        if wants {
            let kind = if brakes { Kind::Brake } else { Kind::Query };
            let fresh = self.ask_edp(kind, flag::WANT_STATE);
            fresh.map_err(|fault| self.fail(fault))?;
            flags |= flag::STATE;
        }
        if brakes {
            self.moving = !self.driver.is(flag::STANDSTILL);
            flags &= if self.moving { !flag::ENDED } else { !0 };
        }
        self.answer(flags);
        Ok(())
    }

    /// Brings the robot to a standstill when a motion left it moving: the braking tail.
    fn settle(&mut self) -> Result<(), Fault> {
        while self.moving {
            // Without an open order there is no step to brake in.
            match self.next_order()? {
                Kind::Stop => return Err(self.stopped()),
                _ => {
                    let braked = self.ask_edp(Kind::Brake, flag::WANT_STATE);
                    braked.map_err(|fault| self.fail(fault))?;
                    if self.driver.is(flag::STANDSTILL) {
                        self.moving = false;
                    } else {
                        self.answer(flag::STATE);
                    }
                }
            }
        }
        Ok(())
    }

    /// The same, unless the MP's END hands the moving robot over to its next instruction.
    fn settle_unless_blending(&mut self) -> Result<(), Fault> {
        let ended = self.open && self.order.header.kind == Kind::End;
        if ended && self.order.is(flag::BLEND) { Ok(()) } else { self.settle() }
    }

    /// Whether a demand of the open order's step would miss the EDP's ticks.
    fn is_late(&self) -> bool {
        self.waiter.now() >= self.order.header.step * self.period + self.grace
    }

    /// The open order's value for a step function that reads it; for one that does not, a value of zeros.
    fn read_order<P: Payload>(&mut self, reads: bool) -> Result<Order<P>, Fault> {
        let words = if reads { self.order.words() } else { &EMPTY };
        P::get(words).map(Order::new).map_err(|_| self.fail(Fault::new(FaultKind::Message)))
    }

    fn check_payload<P: Payload>(&mut self, reads: bool) -> Result<(), Fault> {
        match self.instruction {
            Some(instruction) if reads && instruction.id != P::ID => {
                let text =
                    format!("the step function reads `{}`, the order is `{}`", P::NAME, instruction.name);
                Err(self.fail(Fault::new(FaultKind::PayloadMismatch).text(&text)))
            }
            _ => Ok(()),
        }
    }

    fn check_ready(&mut self) -> Result<(), Fault> {
        self.check_latch()?;
        if self.instruction.is_none() {
            let text = "Move or Wait outside obey: write `ecp.obey(|ecp, order: YourOrder| ..)` around it";
            return Err(self.fail(Fault::thrown(text)));
        }
        let over = match self.order.header.kind {
            Kind::End if self.open => FaultKind::InstructionEnded,
            Kind::Abort if self.open => FaultKind::Aborted,
            _ => return Ok(()),
        };
        self.refuse();
        Err(Fault::new(over).in_process(self.process))
    }

    fn check_latch(&mut self) -> Result<(), Fault> {
        match &self.latched {
            Some(fault) => {
                let fault = fault.clone();
                self.refuse();
                Err(fault)
            }
            None => Ok(()),
        }
    }

    /// Counts refused calls: a program that loops over them is ended at the process's boundary.
    fn refuse(&mut self) {
        self.refusals += 1;
        if self.refusals > MAX_REFUSALS {
            // The program is over: what the process does after it counts anew.
            self.refusals = 0;
            std::panic::resume_unwind(Box::new("the program ignores a fault or the end of its instruction"));
        }
    }

    /// A fault of this process: latches it, stops the robot, tells the MP; returns at standstill.
    fn fail(&mut self, fault: Fault) -> Fault {
        if let Some(latched) = &self.latched {
            return latched.clone();
        }
        let fault = fault.in_process(self.process).at_step(self.order.header.step);
        if fault.kind() == FaultKind::CellClosed {
            return fault;
        }
        self.latched = Some(fault.clone());
        loop {
            // A faulty EDP answers with its fault, and its standstill is in the flags all the same.
            let answered = self.ask_edp(Kind::Stop, 0);
            let lost = answered.is_err() && self.driver.header.kind != Kind::Fault;
            let standstill = lost || self.driver.is(flag::STANDSTILL);
            if self.open {
                self.answer_fault(&fault);
            }
            if standstill || self.next_order().is_err() {
                self.moving = false;
                return fault;
            }
        }
    }

    /// The MP stops the cell for a fault elsewhere.
    fn stopped(&mut self) -> Fault {
        let fault = Fault::new(FaultKind::StoppedByCell).at_step(self.order.header.step);
        self.fail(fault)
    }

    /// Runs the robot's program, then serves the MP until the cell closes. Returns the program's outcome.
    pub(crate) fn run_program(
        &mut self,
        program: impl FnOnce(&mut Self) -> Result<(), Fault>,
    ) -> Result<(), Fault> {
        let run = std::panic::AssertUnwindSafe(|| program(self));
        let outcome =
            std::panic::catch_unwind(run).unwrap_or_else(|panic| Err(crate::fault::panicked(&*panic)));
        match outcome {
            Err(fault) if fault.kind() != FaultKind::CellClosed && fault.kind() != FaultKind::Aborted => {
                Err(self.fail(fault))
            }
            // A program that swallows a latched fault does not undo it.
            outcome => self.latched.clone().map_or(outcome, Err),
        }
    }

    /// Answers for a program that is over.
    pub(crate) fn serve(&mut self, outcome: &Result<(), Fault>) {
        while let Ok(kind) = self.next_order() {
            match (kind, &self.latched) {
                (_, Some(fault)) => {
                    let fault = fault.clone();
                    let _ = self.ask_edp(Kind::Stop, 0);
                    self.answer_fault(&fault);
                }
                (Kind::Start, None) => {
                    let text = match outcome {
                        Ok(()) => "the program of this ECP is over; the MP starts another instruction",
                        Err(_) => "the program of this ECP ended with a fault",
                    };
                    self.fail(Fault::thrown(text));
                }
                (Kind::Stop, None) => {
                    self.stopped();
                }
                (_, None) => {
                    if self.hold(flag::ENDED | flag::FINISHED).is_err() {
                        return;
                    }
                }
            }
        }
    }
}

const EMPTY: [u64; crate::wire::WORDS] = [0; crate::wire::WORDS];
