//! The program of an MP from its first line to its end, and again after a fault.
//!
//! In: the program, what the cell is to do after a fault, the operator. Out: how the program ended. While the cell is
//! latched the MP asks every robot in every step whether it stands; a reset makes all of them ready, in a new epoch, and
//! then waits until their drives have held for some steps.

use crate::link::message::{OrderKind, flag};
use crate::model::driver::RECOVERY;
use crate::model::fault::{Fault, FaultKind};
use crate::model::type_name::TypeName;
use crate::safety::latch::AfterFault;
use crate::safety::latch::{Event, Latch};

use crate::operator::state::InstructionKind;

use super::Mp;
use super::robots::SILENT;

/// Steps for which drives hold after a reset before a program starts: one that cannot says so.
const TRIAL: u64 = 5;

/// What a latched cell is told to do.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Verdict {
    Restart,
    End,
}

impl Mp<'_> {
    /// Runs the coordinating program, again after every reset.
    pub(crate) fn run_program(
        &mut self,
        after_fault: AfterFault,
        mut program: impl FnMut(&mut Self) -> Result<(), Fault>,
    ) -> Result<(), Fault> {
        loop {
            let outcome = self.run_once(&mut program);
            match outcome {
                Err(fault)
                    if after_fault == AfterFault::AwaitReset && fault.kind() != FaultKind::CellClosed =>
                {
                    // A program that ended with a fault of its own is latched as one that was stopped for it.
                    let cause = self.stops.latched.clone().unwrap_or_else(|| self.stop(fault));
                    if self.await_reset(&cause) == Verdict::End {
                        return Err(cause);
                    }
                }
                Ok(()) | Err(_) => return outcome,
            }
        }
    }

    /// Runs it once. A panic in it stops the robots as any fault does.
    fn run_once(&mut self, program: &mut impl FnMut(&mut Self) -> Result<(), Fault>) -> Result<(), Fault> {
        let run = std::panic::AssertUnwindSafe(|| {
            self.operating.count_from_here();
            self.operating.operator.show_homing(true);
            let homed = self.out_of_serve(InstructionKind::Homing, TypeName::NONE, Self::home);
            self.operating.operator.show_homing(false);
            homed?;
            program(self)
        });
        let outcome = match std::panic::catch_unwind(run) {
            Ok(outcome) => {
                let settled = self.settle().and_then(|()| self.end_background());
                let settled = settled.map_err(|fault| self.stop(fault));
                // A program that swallows a latched fault does not undo it.
                let latched = self.stops.latched.clone().map_or(Ok(()), Err);
                outcome.map_err(|fault| fault.in_process(self.process)).and(settled).and(latched)
            }
            Err(panic) => {
                let fault = crate::model::fault::panicked(&*panic)
                    .in_process(self.process)
                    .in_instruction(self.operating.instruction())
                    .at_step(self.clock.step());
                self.operating.show_end(self.state(), self.host.console);
                Err(self.stop(fault))
            }
        };
        self.operating.operator.end();
        outcome
    }

    /// Holds a latched cell until its operator resets it or gives it up, or a process is gone.
    fn await_reset(&mut self, cause: &Fault) -> Verdict {
        let mut failed = None;
        let mut told = None;
        loop {
            if self.begin_step().is_err()
                || self.operating.operator.has_given_up()
                || self.stops.gone.is_some()
            {
                return Verdict::End;
            }
            self.heed_reset();
            if self.operating.operator.latch() == Latch::Resetting {
                match self.reset() {
                    Ok(()) => return Verdict::Restart,
                    Err(fault) => {
                        // The first cause is kept.
                        self.stops.latched = Some(cause.clone());
                        self.stop(fault.clone());
                        failed = Some(fault);
                    }
                }
            }
            // It is stopped already. One that comes with the reset ends that.
            self.operating.operator.take_protective_stop();
            match self.what_persists() {
                Ok(persisting) => {
                    self.tell_standstill();
                    let _ = self.operating.operator.meet(Event::Cause { persists: persisting.is_some() });
                    // What made the last reset fail, where nothing forbids the next one.
                    let tells = persisting.or_else(|| failed.clone());
                    if told != tells {
                        self.operating.show_persisting(tells.as_ref());
                        told = tells;
                    }
                }
                Err(_) => return Verdict::End,
            }
        }
    }

    /// What forbids a reset: a robot that moves or does not answer, a guard that does not look any more.
    ///
    /// # Errors
    /// The cell closes.
    fn what_persists(&mut self) -> Result<Option<Fault>, Fault> {
        let all = self.robots.all();
        // Every reply is a fault; what counts is that the robots stand.
        let answered = self.exchange(&all, OrderKind::Stop, 0);
        if let Err(closed) = answered
            && closed.is_orderly()
        {
            return Err(closed);
        }
        for robot in self.robots.iter() {
            let lost = |text| Some(Fault::new(FaultKind::PeerLost).in_process(robot.process()).text(text));
            if robot.is_silent {
                return Ok(lost(SILENT));
            }
            if !robot.reply.is(flag::STANDSTILL) {
                return Ok(lost("the robot does not come to a standstill"));
            }
        }
        if let Some(from_above) = self.stopped_from_above() {
            return Ok(Some(from_above));
        }
        Ok(self.stops.guard_is_asleep().then(|| {
            let fault = Fault::new(FaultKind::Panicked).in_process(self.process);
            fault.text("the guard panicked and does not look any more: start the cell again")
        }))
    }

    /// Lets each robot in turn do what it needs after a stop of its own; what it refuses, the reset fails with.
    ///
    /// # Errors
    /// The cell closes.
    fn recover(&mut self) -> Result<(), Fault> {
        for index in 0..self.robots.len() {
            let most = self.clock.step() + self.clock.steps_of(RECOVERY);
            loop {
                self.begin_step()?;
                match self.exchange(&[index], OrderKind::Stop, flag::RECOVER) {
                    Err(fault) if fault.is_orderly() => return Err(fault),
                    // Every answer of a latched robot is a fault.
                    Ok(()) | Err(_) => {}
                }
                let robot = &self.robots[index];
                let goes_on = robot.is_silent || robot.reply.is(flag::RECOVERS);
                if !goes_on || self.clock.step() >= most || self.operating.operator.has_given_up() {
                    break;
                }
            }
        }
        Ok(())
    }

    /// Makes every robot ready for a restart, in a new epoch; nothing moves.
    ///
    /// # Errors
    /// What is still wrong.
    fn reset(&mut self) -> Result<(), Fault> {
        if let Some(from_above) = self.stopped_from_above() {
            return Err(from_above);
        }
        self.recover()?;
        self.robots.epoch += 1;
        self.stops.forget();
        self.clock.forget_late_steps();
        if self.operating.operator.take_protective_stop() {
            return Err(Fault::of_operator().in_process(self.process));
        }
        let all = self.robots.all();
        self.exchange(&all, OrderKind::Reset, 0)?;
        for _ in 0..TRIAL {
            self.begin_step()?;
            self.exchange(&all, OrderKind::Query, 0)?;
            if let Some(fault) = self.stops.protective.take() {
                // A guard's, or the operator's: a stop has priority over a start.
                return Err(fault);
            }
        }
        self.forget();
        Ok(())
    }

    /// Programs find what they found when the cell began.
    fn forget(&mut self) {
        self.robots.release();
        self.sensing.release();
        let _ = self.operating.operator.meet(Event::Restart);
        self.operating.show_persisting(None);
        self.operating.operator.forget();
        if let Some(upper) = &mut self.upper {
            upper.begin();
        }
    }
}
