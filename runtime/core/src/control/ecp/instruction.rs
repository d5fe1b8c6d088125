//! What an ECP does with the orders of one instruction, from START to the answer to END.
//!
//! In: orders, as [`orders`](super::orders) tells them from one another. Out: the program's first order; the robot at a standstill
//! when the program has returned.

use crate::link::message::{OrderKind, RequestKind, flag};
use crate::model::fault::{Fault, FaultKind};
use crate::model::list::PayloadType;
use crate::model::robot::Robot;

use super::Ecp;
use super::orders::{Duty, Phase};

/// What an order asks for before an instruction is at work.
pub(super) enum BeforeStart {
    /// Acknowledge START.
    Open,
    /// Begin to work: it is the first step's.
    FirstStep,
    /// Hold: the instruction has been left already, or is over before its first step.
    StayOut,
}

/// What an order asks for in an instruction.
pub(super) enum OfInstruction {
    /// Do a step, or hold when the program has finished.
    Step,
    /// Leave the instruction, which ends.
    End,
    /// Leave the instruction, which the operator aborts.
    Abort,
}

impl<R: Robot> Ecp<'_, R> {
    /// Waits for START and the first order, which is open then.
    pub(super) fn await_start(&mut self, payload: PayloadType) -> Result<(), Fault> {
        loop {
            match self.next_before_start()? {
                BeforeStart::Open => self.open(payload)?,
                BeforeStart::FirstStep => return Ok(()),
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
    pub(super) fn open(&mut self, payload: PayloadType) -> Result<(), Fault> {
        if self.orders.header().payload != payload.id {
            let fault = Fault::new(FaultKind::PayloadMismatch);
            return Err(self.fail(fault.text(&format!("this ECP serves orders of type `{}`", payload.name))));
        }
        self.ask(RequestKind::Query, flag::FIRST | flag::WANT_STATE)?;
        self.orders.start(payload);
        self.reply(flag::STATE);
        self.refusals = 0;
        Ok(())
    }

    /// Holds after the program's return until the MP ends the instruction.
    pub(super) fn finish(&mut self, outcome: Result<(), Fault>) -> Result<(), Fault> {
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
    pub(super) fn check_latch_of(&self, outcome: &Result<(), Fault>) -> Result<(), Fault> {
        match (&self.orders.phase, outcome) {
            (Phase::Latched(latched), Ok(())) => Err(latched.clone()),
            (Phase::Latched(_), Err(fault)) => Err(fault.clone()),
            (Phase::Idle | Phase::Started | Phase::Serving | Phase::Finished, _) => Ok(()),
        }
    }

    /// What the next order, or the one that is still open, asks for while no instruction is at work.
    pub(super) fn next_before_start(&mut self) -> Result<BeforeStart, Fault> {
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
    pub(super) fn next_of_instruction(&mut self) -> Result<OfInstruction, Fault> {
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

    /// What the next order, or the one that is still open, asks for. A question about the robot's state is answered here,
    /// in any phase.
    pub(super) fn next_duty(&mut self) -> Result<Duty, Fault> {
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
    pub(super) fn decline(&mut self, duty: Duty) -> Fault {
        if duty == Duty::Stop {
            // The MP stops the cell for a fault elsewhere.
            return self.fail(Fault::new(FaultKind::StoppedByCell));
        }
        let order = self.orders.open();
        let text = format!("order {order:?} in phase {:?}", self.orders.phase);
        self.fail(Fault::new(FaultKind::Message).text(&text))
    }
}
