//! What an ECP refuses once a fault is latched or its instruction is over, and how it stops its robot for a fault.

use crate::link::message::{OrderKind, RequestKind};
use crate::model::fault::{Ended, Fault, FaultKind};
use crate::model::robot::Robot;

use super::orders::Phase;
use super::{Ecp, MAX_REFUSALS};

impl<R: Robot> Ecp<'_, R> {
    pub(super) fn check_ready(&mut self) -> Result<(), Fault> {
        self.check_latch()?;
        if self.orders.payload().is_none() {
            let text = "Move or Wait outside serve: write `ecp.serve(|ecp, order: YourOrder| ..)` around it";
            return Err(self.fail(Fault::thrown(text)));
        }
        let Some(ended_by) = self.orders.ended_by() else { return Ok(()) };
        self.refuse();
        Err(self.instruction_over(ended_by == OrderKind::Abort))
    }

    /// How an instruction that the MP has ended ends the Move or Wait at work in it.
    pub(super) fn instruction_over(&self, aborted: bool) -> Fault {
        let kind = if aborted { FaultKind::Aborted } else { FaultKind::InstructionEnded };
        Fault::orderly(kind).in_process(self.process).in_instruction(self.instruction())
    }

    pub(super) fn check_latch(&mut self) -> Result<(), Fault> {
        match &self.orders.phase {
            Phase::Latched(fault) => {
                let fault = fault.clone();
                self.refuse();
                Err(fault)
            }
            Phase::Idle | Phase::Started | Phase::Serving | Phase::Finished => Ok(()),
        }
    }

    /// Counts refused calls: a program that loops over them is ended at the process's boundary.
    pub(super) fn refuse(&mut self) {
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
    pub(super) fn fail(&mut self, fault: Fault) -> Fault {
        if let Phase::Latched(latched) = &self.orders.phase {
            return latched.clone();
        }
        let fault = fault.in_process(self.process).at_step(self.orders.header().step);
        let fault = fault.in_instruction(self.instruction());
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
    pub(super) fn stop_driver(&mut self) -> bool {
        let asked = self.driver.ask(RequestKind::Stop, 0, self.orders.header(), self.host.waiter);
        // A faulty EDP answers with its fault, and its standstill is in the flags all the same.
        let lost = asked.is_err() && !self.driver.has_fault();
        lost || self.driver.is_at_standstill()
    }
}
