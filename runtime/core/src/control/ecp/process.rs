//! The process round an ECP's program: its boundary, what it answers when the program is over, and its reset.

use crate::link::message::{OrderKind, RequestKind, flag};
use crate::model::fault::{Fault, FaultKind};
use crate::model::robot::Robot;

use super::orders::{Duty, Phase};
use super::{AtWork, Ecp, Trouble};

impl<R: Robot> Ecp<'_, R> {
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
                Phase::Idle | Phase::Started | Phase::Serving | Phase::Finished => outcome,
            },
        }
    }

    /// Answers for a program that is over; whether a reset starts it again. Otherwise the cell closes.
    pub(crate) fn answer_after_program(&mut self, outcome: &Result<(), Fault>) -> bool {
        while let Ok(order) = self.orders.receive(self.host.waiter) {
            match self.serve_one(order, outcome) {
                Ok(Served::Reset) => return true,
                // The cell closed before its EDP had answered: the order stays open, and nobody waits for its answer.
                Err(fault) if fault.kind() == FaultKind::CellClosed => return false,
                // A fault in between is latched, and the answer to the next order.
                Ok(Served::Answered) | Err(_) => {}
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
        self.at_work = AtWork::default();
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
