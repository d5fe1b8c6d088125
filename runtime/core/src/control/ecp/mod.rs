//! ECP: the effector control process, the task for one robot.
//!
//! In: the MP's orders, one per step. Out: demands to the EDP, and in each reply to the MP the robot's image
//! and how fast the rate may change. The MP paces: a step of an ECP begins with an order, and its answer ends
//! it. [`orders`] is the MP's side of it, [`driver`] the EDP's, [`motion`] the Move between them and [`waiting`]
//! the Wait; here is what holds them together: instructions, standstill, faults.

mod driver;
mod motion;
mod orders;
#[cfg(test)]
mod tests;
mod waiting;

use crate::link::Host;
use core::time::Duration;
use std::rc::Rc;

use crate::control::overruns::Overruns;
use crate::control::replay::RecordedRobot;
use crate::control::sensing::Sensing;
use crate::link::message::{OrderKind, RequestKind, flag};
use crate::link::{Client, Server};
use crate::model::fault::{Ended, Fault, FaultKind, ProcessId};
use crate::model::image::{RobotImage, Sensor};
use crate::model::list::{PayloadType, SensorHandle};
use crate::model::payload::{Nudge, Order, Payload};
use crate::model::robot::Robot;
use crate::model::time::Nanos;
use crate::observe::witness::{What, Witnesses};

use driver::DriverPort;
use orders::{Duty, Orders, Phase};

/// What an order asks for before an instruction is at work.
enum BeforeStart {
    /// Acknowledge START.
    Open,
    /// Begin to work: it is the first step's.
    FirstStep,
    /// Hold: the instruction has been left already, or is over before its first step.
    StayOut,
}

/// What an order asks for in an instruction.
enum OfInstruction {
    /// Do a step, or hold when the program has finished.
    Step,
    /// Leave the instruction, which ends.
    End,
    /// Leave the instruction, which the operator aborts.
    Abort,
}

/// An effector control process: what a robot's program is given.
pub struct Ecp<'w, R: Robot> {
    process: ProcessId,
    host: Host<'w>,
    orders: Orders,
    driver: DriverPort<R>,
    sensing: Sensing,
    pace: Pace,
    overruns: Overruns,
    refusals: u32,
    /// What the MP has been told, or will be, to stop the robot for on its path.
    trouble: Trouble,
    /// Where late steps are shown, and those of a run that is replayed.
    witnesses: Witnesses,
    replayed: Option<Rc<RecordedRobot>>,
}

/// What is wrong while demands are sound.
#[derive(Clone, Debug, PartialEq)]
enum Trouble {
    None,
    /// Not reported yet.
    New(Fault),
    /// Reported: the MP lets path time slow down.
    Told(Fault),
}

/// The times that an ECP goes by.
#[derive(Clone, Copy, Debug)]
pub struct Pace {
    /// The cell's step \[ns\].
    pub period: Nanos,
    /// The time into a step after which its demand would come too late for the EDP's ticks \[ns\].
    pub grace: Nanos,
    /// Steps after which a robot that was told to stop must stand.
    pub stop_steps: u64,
}

/// Refused calls after which a program that ignores a latched fault, or the end of the cell, is ended.
pub(crate) const MAX_REFUSALS: u32 = 10_000;

impl<'w, R: Robot> Ecp<'w, R> {
    pub(crate) fn new(
        process: ProcessId,
        host: Host<'w>,
        mp: Box<dyn Server>,
        edp: Box<dyn Client>,
        sensing: Sensing,
        pace: Pace,
        replayed: Option<Rc<RecordedRobot>>,
    ) -> Self {
        Ecp {
            process,
            host,
            orders: Orders::new(mp),
            driver: DriverPort::new(edp, sensing.patience),
            witnesses: sensing.witnesses.clone(),
            sensing,
            overruns: Overruns::new(Duration::from_nanos(pace.period)),
            pace,
            refusals: 0,
            trouble: Trouble::None,
            replayed,
        }
    }

    /// The robot's image at the end of the last motion or Wait.
    #[must_use]
    pub const fn image(&self) -> &RobotImage<R> {
        &self.driver.image
    }

    /// The handle of a virtual sensor of this robot, in its default configuration.
    ///
    /// # Errors
    /// `Config` when the cell gives this ECP no sensor of that name and kind, or when its handle is taken.
    pub fn sensor<S: Sensor>(&mut self, name: &str) -> Result<SensorHandle<S>, Fault>
    where
        S::Configuration: Default,
    {
        self.sensing.handle(name, S::Configuration::default(), self.process)
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
        if let Some(payload) = self.orders.payload() {
            let text = if payload.id == PayloadType::of::<Nudge>().id {
                "the cell has no MP program, whose orders could be obeyed: leave `obey` out, or give it one"
            } else {
                "obey inside obey: an ECP obeys one instruction at a time"
            };
            return Err(self.fail(Fault::thrown(text)));
        }
        let value = self.await_start::<P>()?;
        let outcome = program(self, value);
        self.finish(outcome)
    }

    /// Obeys one instruction after another, each as [`obey`](Self::obey) does, until the MP's program is over.
    ///
    /// # Errors
    /// As [`obey`](Self::obey), except that the end of the MP's program is no fault here. An abort is one: a program whose
    /// MP goes on after it calls this again.
    pub fn obey_all<P: Payload>(
        &mut self,
        mut program: impl FnMut(&mut Self, P) -> Result<(), Fault>,
    ) -> Result<(), Fault> {
        loop {
            if let Err(fault) = self.obey(&mut program) {
                let closed = fault.is_orderly() && fault.kind() == FaultKind::CellClosed;
                // Between two instructions, not in one that was opened.
                return if closed && self.orders.phase == Phase::Idle { Ok(()) } else { Err(fault) };
            }
        }
    }

    /// Waits for START and the first order.
    fn await_start<P: Payload>(&mut self) -> Result<P, Fault> {
        loop {
            match self.next_before_start()? {
                BeforeStart::Open => self.open::<P>()?,
                BeforeStart::FirstStep => {
                    let first = P::get(self.orders.words());
                    let first = first.map_err(|_| self.fail(Fault::new(FaultKind::Message)))?;
                    self.orders.phase = Phase::Obeying;
                    return Ok(first);
                }
                // The tail of an instruction that has ended here, the end of one before its first step, or a
                // blend that no Move takes over.
                BeforeStart::StayOut => {
                    self.orders.phase = Phase::Idle;
                    self.hold(flag::ENDED | flag::FINISHED)?;
                }
            }
        }
    }

    /// Acknowledges START: the type of the orders is right, and the robot stands where it was told to stand.
    fn open<P: Payload>(&mut self) -> Result<(), Fault> {
        if self.orders.header().payload != P::ID {
            let fault = Fault::new(FaultKind::PayloadMismatch);
            return Err(self.fail(fault.text(&format!("this ECP obeys orders of type `{}`", P::NAME))));
        }
        self.ask(RequestKind::Query, flag::FIRST | flag::WANT_STATE)?;
        self.orders.start(PayloadType::of::<P>());
        self.reply(flag::STATE);
        self.refusals = 0;
        Ok(())
    }

    /// Holds after the program's return until the MP ends the instruction.
    fn finish(&mut self, outcome: Result<(), Fault>) -> Result<(), Fault> {
        self.check_latch_of(&outcome)?;
        let settled = self.settle_unless_blending();
        match outcome.and(settled) {
            Ok(()) => {}
            // What the MP's open order says counts, not what the program returns.
            Err(fault) if fault.is_orderly() && fault.kind() == FaultKind::CellClosed => return Err(fault),
            Err(fault) => match self.orders.ended_by() {
                Some(OrderKind::End) if fault.is_orderly() => {}
                Some(OrderKind::Abort) if fault.is_orderly() => {}
                Some(_) | None => return Err(self.fail(fault.thrown_by_program())),
            },
        }
        self.orders.phase = Phase::Finished;
        loop {
            match self.next_of_instruction()? {
                OfInstruction::Step => self.hold(flag::FINISHED)?,
                OfInstruction::End => {
                    self.orders.phase = Phase::Idle;
                    return self.hold(flag::ENDED | flag::FINISHED);
                }
                OfInstruction::Abort => {
                    self.orders.phase = Phase::Idle;
                    self.hold(flag::ENDED | flag::FINISHED)?;
                    return Err(Fault::orderly(FaultKind::Aborted).in_process(self.process));
                }
            }
        }
    }

    /// A latched fault is what a program ends with, whatever it returns, unless that is a fault of its own.
    fn check_latch_of(&self, outcome: &Result<(), Fault>) -> Result<(), Fault> {
        match (&self.orders.phase, outcome) {
            (Phase::Latched(latched), Ok(())) => Err(latched.clone()),
            (Phase::Latched(_), Err(fault)) => Err(fault.clone()),
            (Phase::Idle | Phase::Started | Phase::Obeying | Phase::Finished, _) => Ok(()),
        }
    }

    /// What the next order, or the one that is still open, asks for while no instruction is at work.
    fn next_before_start(&mut self) -> Result<BeforeStart, Fault> {
        match self.next_duty()? {
            Duty::Open => Ok(BeforeStart::Open),
            Duty::Work => Ok(BeforeStart::FirstStep),
            Duty::StayOut => Ok(BeforeStart::StayOut),
            duty @ (Duty::Rest
            | Duty::End
            | Duty::Abort
            | Duty::Report
            | Duty::Stop
            | Duty::Refuse
            | Duty::Reset
            | Duty::Foreign) => Err(self.decline(duty)),
        }
    }

    /// What the next order, or the one that is still open, asks for in an instruction that is at work.
    fn next_of_instruction(&mut self) -> Result<OfInstruction, Fault> {
        match self.next_duty()? {
            Duty::Work | Duty::Rest => Ok(OfInstruction::Step),
            Duty::End => Ok(OfInstruction::End),
            Duty::Abort => Ok(OfInstruction::Abort),
            duty @ (Duty::Open
            | Duty::StayOut
            | Duty::Report
            | Duty::Stop
            | Duty::Refuse
            | Duty::Reset
            | Duty::Foreign) => Err(self.decline(duty)),
        }
    }

    /// What the next order, or the one that is still open, asks for. A question about the robot's state is answered on the
    /// way, in any phase.
    fn next_duty(&mut self) -> Result<Duty, Fault> {
        loop {
            let Ok(order) = self.orders.receive(self.host.waiter) else {
                self.refuse();
                return Err(Fault::orderly(FaultKind::CellClosed).in_process(self.process));
            };
            match self.orders.duty(order) {
                Duty::Report => self.hold(0)?,
                duty @ (Duty::Open
                | Duty::Work
                | Duty::Rest
                | Duty::End
                | Duty::Abort
                | Duty::StayOut
                | Duty::Stop
                | Duty::Refuse
                | Duty::Reset
                | Duty::Foreign) => return Ok(duty),
            }
        }
    }

    /// The fault of an order that this process cannot follow.
    fn decline(&mut self, duty: Duty) -> Fault {
        if duty == Duty::Stop {
            // The MP stops the cell for a fault elsewhere.
            return self.fail(Fault::new(FaultKind::StoppedByCell));
        }
        let order = self.orders.open();
        let text = format!("order {order:?} in phase {:?}", self.orders.phase);
        self.fail(Fault::new(FaultKind::Message).text(&text))
    }

    /// Answers the open order.
    fn reply(&mut self, flags: u32) {
        self.orders.reply(flags, self.driver.reply());
    }

    /// Answers the open order, with the robot's image if the EDP gave it in this step; or with what is wrong, once.
    fn reply_with_state(&mut self) {
        if let Trouble::New(fault) = &self.trouble {
            let fault = fault.clone();
            self.orders.reply_trouble(&fault, self.driver.reply());
            self.trouble = Trouble::Told(fault);
            return;
        }
        self.reply(self.driver.reply().header.flags & flag::STATE);
    }

    /// One exchange with the EDP.
    fn ask(&mut self, kind: RequestKind, flags: u32) -> Result<(), Fault> {
        let asked = self.driver.ask(kind, flags, self.orders.header(), self.host.waiter);
        asked.map_err(|fault| self.fail(fault))
    }

    /// Answers a step in which the robot stands. One that a blend left moving brakes, unless this very order
    /// hands it over; it has not left the instruction before it stands.
    fn hold(&mut self, mut flags: u32) -> Result<(), Fault> {
        let brakes = self.driver.moving && !self.orders.hands_over();
        if brakes || self.orders.is(flag::WANT_STATE) || flags & flag::ENDED != 0 {
            let kind = if brakes { RequestKind::Brake } else { RequestKind::Query };
            self.ask(kind, flag::WANT_STATE)?;
            flags |= self.driver.reply().header.flags & flag::STATE;
        }
        if brakes {
            self.driver.moving = !self.driver.is_at_standstill();
            flags &= if self.driver.moving { !flag::ENDED } else { !0 };
        }
        self.reply(flags);
        Ok(())
    }

    /// Brings the robot to a standstill when a motion left it moving: the braking tail.
    fn settle(&mut self) -> Result<(), Fault> {
        while self.driver.moving {
            // Without an open order there is no step to brake in.
            self.next_of_instruction()?;
            self.ask(RequestKind::Brake, flag::WANT_STATE)?;
            if self.driver.is_at_standstill() {
                self.driver.moving = false;
            } else {
                self.reply(flag::STATE);
            }
        }
        Ok(())
    }

    /// The same, unless the MP's END hands the moving robot over to its next instruction.
    fn settle_unless_blending(&mut self) -> Result<(), Fault> {
        if self.orders.hands_over() { Ok(()) } else { self.settle() }
    }

    /// Whether a demand of the open order's step would miss the EDP's ticks, after what took place since `began`.
    fn is_late_since(&self, began: Nanos) -> bool {
        let now = self.host.waiter.now();
        let step = self.orders.header().step;
        let was_late = self.replayed.as_ref().is_some_and(|recorded| recorded.put_off.contains(&step));
        let is_late = was_late || now > began && now >= step * self.pace.period + self.pace.grace;
        if is_late {
            self.witnesses.show(now, &What::Late { step }, &[]);
        }
        is_late
    }

    /// The open order's value for a step function that reads it; for one that does not, a value of zeros.
    fn read_order<P: Payload>(&mut self, reads: bool) -> Result<Order<P>, Fault> {
        let order = if reads { P::get(self.orders.words()).map(Order::new) } else { Order::unread() };
        order.map_err(|_| self.fail(Fault::new(FaultKind::Message)))
    }

    fn check_payload<P: Payload>(&mut self, reads: bool) -> Result<(), Fault> {
        match self.orders.payload() {
            Some(payload) if reads && payload.id != P::ID => {
                let text = format!("the step function reads `{}`, the order is `{}`", P::NAME, payload.name);
                Err(self.fail(Fault::new(FaultKind::PayloadMismatch).text(&text)))
            }
            Some(_) | None => Ok(()),
        }
    }

    fn check_ready(&mut self) -> Result<(), Fault> {
        self.check_latch()?;
        if self.orders.payload().is_none() {
            let text = "Move or Wait outside obey: write `ecp.obey(|ecp, order: YourOrder| ..)` around it";
            return Err(self.fail(Fault::thrown(text)));
        }
        let Some(ended_by) = self.orders.ended_by() else { return Ok(()) };
        self.refuse();
        Err(self.instruction_over(ended_by == OrderKind::Abort))
    }

    /// How an instruction that the MP has ended ends the Move or Wait at work in it.
    fn instruction_over(&self, aborted: bool) -> Fault {
        let kind = if aborted { FaultKind::Aborted } else { FaultKind::InstructionEnded };
        Fault::orderly(kind).in_process(self.process)
    }

    fn check_latch(&mut self) -> Result<(), Fault> {
        match &self.orders.phase {
            Phase::Latched(fault) => {
                let fault = fault.clone();
                self.refuse();
                Err(fault)
            }
            Phase::Idle | Phase::Started | Phase::Obeying | Phase::Finished => Ok(()),
        }
    }

    /// Counts refused calls: a program that loops over them is ended at the process's boundary.
    fn refuse(&mut self) {
        self.refusals += 1;
        if self.refusals > MAX_REFUSALS {
            // The program is over: what the process does after it counts anew.
            self.refusals = 0;
            std::panic::resume_unwind(Box::new(Ended(
                "ended by the runtime: it ignores a latched fault, the end of its instruction or of the cell",
            )));
        }
    }

    /// A fault of this process: latches it, stops the robot, tells the MP; returns at standstill, or when
    /// it should stand.
    fn fail(&mut self, fault: Fault) -> Fault {
        if let Phase::Latched(latched) = &self.orders.phase {
            return latched.clone();
        }
        let fault = fault.in_process(self.process).at_step(self.orders.header().step);
        if fault.is_orderly() && fault.kind() == FaultKind::CellClosed {
            return fault;
        }
        self.orders.phase = Phase::Latched(fault.clone());
        let began = self.orders.header().step;
        loop {
            let standstill = self.stop_driver();
            if self.orders.open().is_some() {
                self.orders.reply_fault(&fault, self.driver.reply());
            }
            // A robot that does not stand when it must is left to its EDP: nobody waits for it for ever.
            let overdue = self.orders.header().step > began + self.pace.stop_steps;
            if standstill || overdue || self.orders.receive(self.host.waiter).is_err() {
                self.driver.moving = false;
                return fault;
            }
        }
    }

    /// Tells the EDP to stop; whether the robot stands, or its EDP is lost.
    fn stop_driver(&mut self) -> bool {
        let asked = self.driver.ask(RequestKind::Stop, 0, self.orders.header(), self.host.waiter);
        // A faulty EDP answers with its fault, and its standstill is in the flags all the same.
        let lost = asked.is_err() && !self.driver.has_fault();
        lost || self.driver.is_at_standstill()
    }

    /// Runs the robot's program, then serves the MP until the cell closes. Returns the program's outcome.
    pub(crate) fn run_program(
        &mut self,
        program: impl FnOnce(&mut Self) -> Result<(), Fault>,
    ) -> Result<(), Fault> {
        let run = std::panic::AssertUnwindSafe(|| program(self));
        let outcome =
            std::panic::catch_unwind(run).unwrap_or_else(|panic| Err(crate::model::fault::panicked(&*panic)));
        match outcome {
            Err(fault) if !is_over(&fault) => Err(self.fail(fault.thrown_by_program())),
            // A program that swallows a latched fault does not undo it.
            Ok(()) | Err(_) => match &self.orders.phase {
                Phase::Latched(fault) => Err(fault.clone()),
                Phase::Idle | Phase::Started | Phase::Obeying | Phase::Finished => outcome,
            },
        }
    }

    /// Answers for a program that is over; whether a reset starts it again. Otherwise the cell closes.
    pub(crate) fn serve(&mut self, outcome: &Result<(), Fault>) -> bool {
        while let Ok(order) = self.orders.receive(self.host.waiter) {
            // A fault on the way is latched, and the answer to the next order.
            if self.serve_one(order, outcome).is_ok_and(|served| served == Served::Reset) {
                return true;
            }
        }
        false
    }

    fn serve_one(&mut self, order: OrderKind, outcome: &Result<(), Fault>) -> Result<Served, Fault> {
        match self.orders.duty(order) {
            Duty::Refuse => {
                self.stop_driver();
                if let Phase::Latched(fault) = &self.orders.phase {
                    let fault = fault.clone();
                    self.orders.reply_fault(&fault, self.driver.reply());
                }
                Ok(Served::Answered)
            }
            Duty::Reset => self.reset(),
            Duty::Open => {
                let text = match outcome {
                    Ok(()) => "the program of this ECP is over; the MP starts another instruction",
                    Err(_) => "the program of this ECP ended with a fault",
                };
                Err(self.fail(Fault::thrown(text)))
            }
            Duty::Report => self.hold(0).map(|()| Served::Answered),
            Duty::StayOut => self.hold(flag::ENDED | flag::FINISHED).map(|()| Served::Answered),
            duty @ (Duty::Work | Duty::Rest | Duty::End | Duty::Abort | Duty::Stop | Duty::Foreign) => {
                Err(self.decline(duty))
            }
        }
    }

    /// Leaves the latch, if the EDP can: the program finds what it found when the cell began, with the robot where it is.
    fn reset(&mut self) -> Result<Served, Fault> {
        let asked = self.driver.ask(RequestKind::Reset, 0, self.orders.header(), self.host.waiter);
        if let Err(fault) = asked {
            // The cause is still there, or another one is.
            let fault = fault.in_process(self.process);
            self.orders.phase = Phase::Latched(fault.clone());
            self.orders.reply_fault(&fault, self.driver.reply());
            return Ok(Served::Answered);
        }
        self.orders.reset();
        self.sensing.release();
        self.driver.moving = false;
        self.refusals = 0;
        self.trouble = Trouble::None;
        self.reply(0);
        Ok(Served::Reset)
    }
}

/// What became of an order to a process whose program is over.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Served {
    Answered,
    /// The program starts again.
    Reset,
}

/// Whether a program may end with a fault without anything being wrong with its robot.
fn is_over(fault: &Fault) -> bool {
    fault.is_orderly() && matches!(fault.kind(), FaultKind::CellClosed | FaultKind::Aborted)
}
