//! The MP of a lower cell serves: `mp.serve(|mp, order| ..)`, in the same words as an ECP.
//!
//! In: what the upper MP asks for, as [`upper`](super::upper) has heard it. Out: the program's answer to each instruction; this
//! MP's Move and Wait between START and END, which end on their paths when the upper MP ends them.

use crate::link::message::{OrderKind, flag};
use crate::model::fault::{Fault, FaultKind};
use crate::model::list::PayloadType;
use crate::model::payload::Payload;
use crate::model::type_name::TypeName;
use crate::operator::state::InstructionKind;
use crate::safety::latch::{Event, Latch};

use super::Mp;
use super::upper::{SILENT, Upper};

impl Mp<'_> {
    /// Does this cell's part of one instruction of the MP above it, in a cell that is
    /// [one of another cell's](crate::cell::Cell::cell): `program` is run with the order when that MP starts an instruction of
    /// this payload; its return means *finished*. All robots then stand until the instruction is ended.
    ///
    /// The payload is an `enum`: cooperation of cells is loose. Moves and Waits of such an MP belong into `program`. When the
    /// upper MP ends the instruction early, the Move or Wait that runs ends on its path, and all later ones at once.
    ///
    /// # Errors
    /// What `program` returned, unless the upper MP has ended the instruction; the cell is latched then, and the upper MP is told.
    /// `Aborted` after an abort from above, which a program may go on after. `PayloadMismatch` when the instruction has orders of
    /// another type: then nothing has moved.
    ///
    /// # Example
    /// ```
    /// use mrroc::prelude::*;
    ///
    /// #[derive(Clone, Copy, Payload)]
    /// enum Job {
    ///     Press { parts: u32 },
    ///     Park,
    /// }
    ///
    /// /// The MP's program of a press cell.
    /// fn press(mp: &mut Mp) -> Result<(), Fault> {
    ///     mp.serve_all(|mp, job: Job| match job {
    ///         Job::Press { parts } => (0..parts).try_for_each(|_| press_one(mp)),
    ///         Job::Park => park(mp),
    ///     })
    /// }
    /// # fn press_one(_: &mut Mp) -> Result<(), Fault> { Ok(()) }
    /// # fn park(_: &mut Mp) -> Result<(), Fault> { Ok(()) }
    /// ```
    pub fn serve<P: Payload>(
        &mut self,
        program: impl FnOnce(&mut Self, P) -> Result<(), Fault>,
    ) -> Result<(), Fault> {
        const { assert!(!P::TIGHT, "a cell serves loose orders: make the payload an `enum`") };
        self.check_latch()?;
        match &self.upper {
            None => {
                let text =
                    "no MP is above this one: run its cell as one of another cell, `.cell(name, cell)`";
                return Err(self.conclude(Fault::new(FaultKind::Config).text(text)));
            }
            Some(upper) if upper.is_serving() => {
                let text = "serve inside serve: a cell serves one instruction at a time";
                return Err(self.conclude(Fault::thrown(text)));
            }
            Some(_) => {}
        }
        let by = TypeName::of::<P>();
        let order = self.out_of_serve(InstructionKind::Wait, by, |mp| mp.await_order::<P>())?;
        let outcome = program(self, order);
        self.finish(by, outcome)
    }

    /// Serves one instruction after another, each as [`serve`](Self::serve) does, until the run is over or a fault is latched. After an
    /// abort from above it goes on.
    ///
    /// # Errors
    /// As [`serve`](Self::serve), without the aborts.
    pub fn serve_all<P: Payload>(
        &mut self,
        mut program: impl FnMut(&mut Self, P) -> Result<(), Fault>,
    ) -> Result<(), Fault> {
        loop {
            match self.serve(&mut program) {
                // Between two instructions, not in one that was opened.
                Err(fault) if self.is_over_between_orders(&fault) => return Ok(()),
                Err(fault) if self.stops.latched.is_some() || fault.kind() != FaultKind::Aborted => {
                    return Err(fault);
                }
                Ok(()) | Err(_) => {}
            }
        }
    }

    fn is_over_between_orders(&self, fault: &Fault) -> bool {
        let closed = fault.is_orderly() && fault.kind() == FaultKind::CellClosed;
        closed && self.upper.as_ref().is_some_and(Upper::is_idle)
    }

    /// Waits for START and the first order; robots that a blend left moving come to rest.
    fn await_order<P: Payload>(&mut self) -> Result<P, Fault> {
        self.settle()?;
        if let Some(upper) = &mut self.upper {
            upper.await_start(PayloadType::of::<P>());
            // A START that has waited for the program is answered at once.
            upper.serve(self.host.waiter.now());
        }
        loop {
            self.rest_a_step()?;
            if let Some(order) = self.upper.as_mut().and_then(Upper::take_first) {
                return order.map_err(|_| Fault::new(FaultKind::Message));
            }
        }
    }

    /// Tells the upper MP that the program has finished, or what is wrong; waits until it ends the instruction.
    fn finish(&mut self, by: TypeName, outcome: Result<(), Fault>) -> Result<(), Fault> {
        if let Some(latched) = &self.stops.latched {
            return Err(outcome.err().unwrap_or_else(|| latched.clone()));
        }
        let rested = self.settle().and_then(|()| self.end_background());
        if let Err(fault) = rested {
            return Err(self.conclude(fault));
        }
        let ended = self.upper.as_ref().is_some_and(|upper| upper.ending().is_some());
        match outcome {
            Err(fault) if fault.is_orderly() && fault.kind() == FaultKind::CellClosed => return Err(fault),
            // The upper MP's END, or its abort.
            Err(fault) if fault.is_orderly() && ended => {}
            Err(fault) => return Err(self.stop(self.of_program(fault))),
            Ok(()) => {}
        }
        if let Some(upper) = &mut self.upper {
            upper.finish();
        }
        let ended = self.out_of_serve(InstructionKind::Wait, by, |mp| mp.await_end())?;
        if ended == OrderKind::Abort {
            return Err(Fault::orderly(FaultKind::Aborted).in_process(self.process));
        }
        Ok(())
    }

    /// The fault that a program ends an order with which the upper MP has not ended.
    fn of_program(&self, fault: Fault) -> Fault {
        let aborted = fault.is_orderly() && fault.kind() == FaultKind::Aborted;
        let fault = if aborted {
            Fault::new(FaultKind::Aborted).text("by the operator of this cell")
        } else {
            fault.thrown_by_program()
        };
        fault.in_process(self.process).at_step(self.clock.step())
    }

    fn await_end(&mut self) -> Result<OrderKind, Fault> {
        loop {
            if let Some(ended) = self.upper.as_mut().and_then(Upper::take_ended) {
                return Ok(ended);
            }
            self.rest_a_step()?;
        }
    }

    /// A step in which no robot is ordered anything; the guard looks.
    fn rest_a_step(&mut self) -> Result<(), Fault> {
        self.clock.spend();
        self.begin_step()?;
        if self.is_ending() {
            return Err(self.ending());
        }
        self.exchange(&[], OrderKind::Query, 0)
    }

    /// What the upper MP has asked for since the last step.
    ///
    /// # Errors
    /// What this cell is to be stopped for.
    pub(super) fn heed_upper(&mut self) -> Result<(), Fault> {
        let (now, step) = (self.host.waiter.now(), self.clock.step());
        let suspended = self.is_suspended();
        let rate = self.clock.feed.rate();
        let Some(upper) = &mut self.upper else { return Ok(()) };
        upper.serve(now);
        upper.show(suspended, rate);
        // A stop that reaches a latched cell keeps it so, and must not end a later reset.
        let wrong = upper.take_wrong();
        if self.stops.latched.is_some() {
            return Ok(());
        }
        if let Some(wrong) = wrong {
            return Err(wrong);
        }
        if upper.is_silent(now) {
            let fault = Fault::new(FaultKind::PeerLost).text(SILENT);
            self.stops.protect(fault.in_process(self.process), step);
        }
        Ok(())
    }

    /// Refuses a Move or Wait of a lower cell that is not in an order, or whose order is over.
    pub(super) fn check_order(&mut self) -> Result<(), Fault> {
        let Some(upper) = &self.upper else { return Ok(()) };
        if self.stops.latched.is_some() {
            return Ok(());
        }
        if !upper.is_serving() {
            let text = "Move or Wait outside serve: write `mp.serve(|mp, order: YourOrder| ..)` around it";
            return Err(self.conclude(Fault::thrown(text)));
        }
        let Some(ending) = upper.ending() else { return Ok(()) };
        if self.robots.any_handed_over() || !self.background.is_empty() {
            // These are brought to rest by the instruction itself.
            return Ok(());
        }
        self.stops.refuse();
        self.clock.spend();
        self.begin_step()?;
        Err(ending.in_process(self.process))
    }

    /// The cell is latched by this fault.
    pub(super) fn tell_upper(&mut self, fault: &Fault) {
        if let Some(upper) = &mut self.upper {
            upper.latch(fault);
        }
    }

    /// Whether the robots of a latched cell stand, as far as the upper MP is told.
    pub(super) fn tell_standstill(&mut self) {
        let stand = self.robots.all_say(&self.robots.all(), flag::STANDSTILL);
        if let Some(upper) = self.upper.as_mut().filter(|_| stand) {
            upper.stand();
        }
    }

    /// Why the operator of this cell may not reset it: the upper cell has stopped it.
    pub(super) fn stopped_from_above(&self) -> Option<Fault> {
        self.upper.as_ref().filter(|upper| upper.is_stopped()).map(|_| {
            let text = "stopped by the upper cell: it is reset with that one";
            Fault::new(FaultKind::StoppedByCell).in_process(self.process).text(text)
        })
    }

    /// The operator of the upper cell resets what he has stopped: this cell, too.
    pub(super) fn heed_reset(&mut self) {
        if self.upper.as_mut().is_some_and(Upper::take_reset) {
            let operator = &self.operating.operator;
            // That it was stopped from above forbids it no more; anything else does in the next step.
            let _ = operator.meet(Event::Cause { persists: false });
            let reset = match operator.latch() {
                Latch::Resetting => Ok(()),
                Latch::Clear | Latch::Stopping | Latch::Latched | Latch::Acknowledged => {
                    operator.acknowledge().and_then(|()| operator.reset())
                }
            };
            if let (Err(why), Some(upper)) = (reset, &mut self.upper) {
                let fault = Fault::thrown(&format!("not reset: {why}")).in_process(self.process);
                upper.latch(&fault);
            }
        }
    }

    /// Answers the upper MP after the program: with the fault that it ended with, or that it is over.
    pub(crate) fn serve_upper(&mut self) {
        let Some(upper) = &mut self.upper else { return };
        upper.be_over();
        loop {
            upper.serve(self.host.waiter.now());
            if self.host.waiter.wait(None).is_err() {
                return;
            }
        }
    }
}
