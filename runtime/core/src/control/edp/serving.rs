//! What an EDP answers: queries, demands, brakes, stops and resets of its ECP.
//!
//! In: a request. Out: the reply, with the robot's image when it is asked for, or with the fault that is latched. A demand
//! is accepted or refused here; [`path`](super::path) makes demands of it. Requests of another epoch than the robot's are
//! ignored.

use crate::control::guarded::guarded;
use crate::control::state_words::StateWords;
use crate::link::message::{RequestKind, flag};
use crate::model::demand::Demand;
use crate::model::fault::{Fault, FaultKind};
use crate::model::image::{RobotImage, RobotState};
use crate::model::robot::Robot;
use crate::model::wire::Wire;
use crate::safety::latch::Admission;
use crate::safety::rate::RateMargin;

use super::Edp;
use super::path::{DemandOutcome, Mode};

impl<R: Robot> Edp<'_, R> {
    /// Serves what has been asked for.
    pub(super) fn serve_requests(&mut self) {
        while self.is_held_back || self.answers.receive() {
            self.is_held_back = self.came_later();
            if self.is_held_back {
                return;
            }
            self.serve();
        }
    }

    /// Whether the request came in a later step in the run that is replayed: what bridged it until then, the robot's state at
    /// that time and all that the answer says depend on it.
    fn came_later(&self) -> bool {
        let Some(replayed) = &self.replayed else { return false };
        let due = replayed.came_late(self.answers.request.header.step, self.answers.nth);
        due.is_some_and(|due| self.clock.due < due)
    }

    pub(super) fn serve(&mut self) {
        // Woken late: what was due before the request's step comes before the request, whatever it asks for.
        while self.clock.due < self.answers.request.header.step && self.host.waiter.now() >= self.clock.next()
        {
            self.advance(self.host.waiter.now());
        }
        self.show_if_late();
        let at_standstill = self.is_at_standstill();
        let admission = self.answers.admit(at_standstill);
        if admission == Admission::Ignored {
            return;
        }
        let result = guarded(|| self.act(admission)).and_then(|result| result);
        if let Err(fault) = result {
            self.stop_for(fault, self.answers.request.header.step);
        }
        if let Err(fault) = guarded(|| self.answer()) {
            self.stop_for(fault, self.answers.request.header.step);
            // With a fault there is no image to compute.
            self.answer();
        }
    }

    /// Shows a request that came too late for its step: a motion has gone on, or has been bridged.
    fn show_if_late(&self) {
        let step = self.answers.request.header.step;
        if step < self.clock.due {
            self.shown.show_late(self.host.waiter.now(), step, self.answers.nth, self.clock.due);
        }
    }

    fn act(&mut self, admission: Admission) -> Result<(), Fault> {
        let request = self.answers.kind().ok_or_else(|| Fault::new(FaultKind::Message))?;
        if admission == Admission::Refused {
            return Err(match request {
                RequestKind::Reset => Fault::new(FaultKind::Message).text("a reset of a robot that moves"),
                RequestKind::Query | RequestKind::Demand | RequestKind::Brake | RequestKind::Stop => {
                    Fault::new(FaultKind::StoppedByCell)
                }
            });
        }
        if self.answers.request.is(flag::ABORTED) {
            self.signals.stop(&mut self.servo)?;
        }
        match request {
            RequestKind::Query => self.check_standing_start(),
            RequestKind::Demand => self.demand(),
            RequestKind::Brake => {
                self.path.come_to_hold();
                Ok(())
            }
            RequestKind::Stop => {
                self.signals.stop(&mut self.servo)?;
                self.brake();
                self.switch_off();
                self.recover();
                Ok(())
            }
            RequestKind::Reset => self.reset(),
        }
    }

    /// Comes to a standstill; where another robot of a tight Move is silent, with that one.
    fn brake(&mut self) {
        let request = &self.answers.request;
        if !request.is(flag::UNANSWERED) {
            return self.path.brake();
        }
        // The order that was not answered is that of the MP's step before.
        let steps = (request.header.duration / self.path.seconds).round() as u64;
        self.path.brake_without(request.header.step.saturating_sub(steps));
    }

    /// A robot that does not stand where it was last told to stand must not start.
    fn check_standing_start(&self) -> Result<(), Fault> {
        if self.answers.request.is(flag::FIRST) && matches!(self.path.mode, Mode::Holding) {
            self.check_following(self.servo.interpolation.goal(), FaultKind::StartPoseMismatch)
                .map_err(|fault| fault.text("the robot is not where its last demand put it"))
        } else {
            Ok(())
        }
    }

    fn demand(&mut self) -> Result<(), Fault> {
        if self.path.is_settled() {
            return Ok(());
        }
        if self.answers.request.is(flag::FIRST) {
            self.path.acceptor.begin();
        }
        let demand = Demand::get(self.answers.request.words());
        let Ok(demand) = &demand else { return Err(Fault::new(FaultKind::Message)) };
        if let Some(sets) = &demand.regulators {
            self.servo.order_regulators(sets)?;
        }
        self.signals.check(demand)?;
        // The tool, the regulators and the outputs that were chosen with it are in force all the same where it is not that of the
        // next step, and a path that ends with this demand ends there.
        let taken = self.path.take(demand, &self.answers.request, self.clock.due)?;
        self.signals.accept(demand);
        if taken == DemandOutcome::InStep {
            self.servo.accept(&demand.coordinates);
        }
        Ok(())
    }

    fn answer(&mut self) {
        let at_standstill = self.is_at_standstill();
        let is_fault = self.answers.begin_reply(at_standstill);
        if !is_fault {
            self.tell_path();
        }
        self.answers.send();
    }

    /// What a reply without a fault says: how fast the rate and the robot may change, and its image, if that is wanted.
    fn tell_path(&mut self) {
        self.path.look_along_twist();
        let is_together = self.path.is_together();
        let acceptor = &self.path.acceptor;
        let header = &mut self.answers.reply.header;
        header.flags |= if is_together { flag::TOGETHER } else { 0 };
        header.rate_margin = RateMargin { most: self.servo.speed_scaling(), ..acceptor.rate_margin() };
        header.law = acceptor.braking_law(self.path.seconds);
        if self.answers.request.is(flag::WANT_STATE) {
            header.flags |= flag::STATE;
            let (joints, velocity) = acceptor.demanded();
            let demanded = RobotState { joints, velocity, pose: acceptor.tool_pose(&joints) };
            let mut image = RobotImage::<R>::new(self.measured_state(), demanded);
            if self.signals.has_any() {
                image = image.with_signals(*self.signals.signals());
            }
            let tool = *acceptor.tool();
            let wrench = self.servo.wrench().map(|at_flange| at_flange.moved(&tool.inverse()));
            let reply = &mut self.answers.reply;
            image.put(&mut reply.body);
            reply.header.len = image.used() as u32;
            if let Some(wrench) = wrench {
                reply.header.len = StateWords::put_wrench(&image, &wrench, &mut reply.body) as u32;
            }
        }
    }
}
