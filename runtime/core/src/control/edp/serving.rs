//! What an EDP answers: queries, demands, brakes, stops and resets of its ECP.
//!
//! In: a request. Out: the reply, with the robot's image when it is asked for, or with the fault that is latched. A demand
//! is accepted or refused here; what becomes of it is [`following`](super::following)'s. What is of another epoch than
//! the robot's is no request.

use crate::link::message::{Kind, RequestKind, flag};
use crate::model::demand::{Coordinates, Demand};
use crate::model::driver::Regulators;
use crate::model::fault::{Fault, FaultKind};
use crate::model::image::{RobotImage, RobotState};
use crate::model::joints::JointVector;
use crate::model::robot::InterpolationSpace;
use crate::model::robot::Robot;
use crate::model::wire::Wire;
use crate::observe::witness::What;
use crate::safety::latch::{Admission, Asked};

use crate::control::guarded::guarded;

use super::{Edp, Mode};

impl<R: Robot> Edp<'_, R> {
    pub(super) fn serve(&mut self) {
        let request = match self.request.header.kind {
            Kind::Request(request) => Some(request),
            Kind::Order(_) | Kind::Command | Kind::Read | Kind::Reply | Kind::Fault => None,
        };
        let asked = request.map_or(Asked::Look, asked);
        let (gate, admission) = self.gate.meet(self.request.header.epoch, asked, self.is_at_standstill());
        self.gate = gate;
        if admission == Admission::Ignored {
            return;
        }
        let result = guarded(|| self.act(request, admission)).and_then(|result| result);
        if let Err(fault) = result {
            self.latch(fault, self.request.header.step);
            self.brake();
        }
        if let Err(fault) = guarded(|| self.answer()) {
            self.latch(fault, self.request.header.step);
            self.brake();
            // With a fault there is no image to compute.
            self.answer();
        }
    }

    fn act(&mut self, request: Option<RequestKind>, admission: Admission) -> Result<(), Fault> {
        let request = request.ok_or_else(|| Fault::new(FaultKind::Message))?;
        if admission == Admission::Refused {
            return Err(match request {
                RequestKind::Reset => Fault::new(FaultKind::Message).text("a reset of a robot that moves"),
                RequestKind::Query | RequestKind::Demand | RequestKind::Brake | RequestKind::Stop => {
                    Fault::new(FaultKind::StoppedByCell)
                }
            });
        }
        match request {
            RequestKind::Query => self.check_standing_start(),
            RequestKind::Demand => self.demand(),
            RequestKind::Brake => {
                self.go_on_until(self.request.header.step);
                self.come_to_hold();
                Ok(())
            }
            RequestKind::Stop => {
                self.go_on_until(self.request.header.step);
                self.brake();
                self.switch_off();
                Ok(())
            }
            RequestKind::Reset => self.reset(),
        }
    }

    /// A motion whose end comes too late for its step has gone on.
    fn go_on_until(&mut self, step: u64) {
        if matches!(self.mode, Mode::Moving { .. }) {
            self.is_late(step);
        }
    }

    /// A robot that does not stand where it was last told to stand must not start.
    fn check_standing_start(&self) -> Result<(), Fault> {
        if self.request.is(flag::FIRST) && matches!(self.mode, Mode::Holding) {
            self.check_following(self.interpolation.goal(), FaultKind::StartPoseMismatch)
                .map_err(|fault| fault.text("the robot is not where its last demand put it"))
        } else {
            Ok(())
        }
    }

    fn demand(&mut self) -> Result<(), Fault> {
        let header = self.request.header;
        // Woken late: what was due before the demand's step comes before the demand.
        while self.due < header.step && self.host.waiter.now() >= self.next_step.min(self.next_tick) {
            self.advance();
        }
        // A step has one demand: one that came twice, or again in place of another, would be a step of its own.
        if self.next.is_some() {
            return Ok(());
        }
        if self.request.is(flag::FIRST) {
            self.acceptor.begin();
        }
        let demand = Demand::get(self.request.words()).map_err(|_| Fault::new(FaultKind::Message))?;
        if let Some(sets) = &demand.regulators {
            self.check_regulators(sets)?;
            self.regulators = Some(*sets);
        }
        // What was to be done in a step that is over has been bridged, and is never made up for; what was chosen with
        // it stays in force, and a path that ends with it ends there.
        if self.is_late(header.step) {
            return self.note_late(&demand);
        }
        // A late demand's own count of periods says how far its path has come; the steps before it were bridged.
        let duration = self.config.step.as_secs_f64();
        let dt = header.dt / header.duration * duration;
        // Periods that the MP left out all robots have missed.
        let all_missed = self.request.is(flag::TOGETHER) && header.duration > 1.5 * duration;
        let accepted = match all_missed {
            true => self.acceptor.rejoin(&demand, dt, duration),
            false => self.acceptor.accept(&demand, dt, duration),
        };
        let first = self.request.is(flag::FIRST) && !matches!(self.mode, Mode::Moving { .. });
        self.next = Some(accepted.map_err(|fault| if first { fault.of_first_demand() } else { fault })?);
        let stands = self.config.space == InterpolationSpace::Task && self.interpolation.stands();
        self.move_together(&demand);
        match demand.coordinates {
            Coordinates::Hold => {}
            Coordinates::Joints(_) => self.task_space.accept(false, stands),
            Coordinates::Pose(_) | Coordinates::Displacement(_) => self.task_space.accept(true, stands),
        }
        self.mode = Mode::Moving { missed: 0 };
        Ok(())
    }

    /// Keeps how the robot brakes with those that it moves together with.
    fn move_together(&mut self, demand: &Demand<R>) {
        self.screw = None;
        let law = self.request.is(flag::TOGETHER).then_some(self.request.header.law);
        self.together = match demand.coordinates {
            // Joints have no screw.
            Coordinates::Hold | Coordinates::Joints(_) => None,
            Coordinates::Pose(_) | Coordinates::Displacement(_) => law,
        };
    }

    /// A demand is too late for its step. A motion that it begins has begun all the same: the robot has missed the steps in
    /// which it stood.
    fn note_late(&mut self, demand: &Demand<R>) -> Result<(), Fault> {
        let header = &self.request.header;
        let begins = self.request.is(flag::FIRST) && matches!(self.mode, Mode::Holding);
        if !begins {
            return self.acceptor.note_late(demand);
        }
        // In a replay what replaces it in its step is found already.
        let missed = if self.next.is_some() { 1 } else { self.due.saturating_sub(header.step) };
        self.move_together(demand);
        let step = self.config.step.as_secs_f64();
        let begun = self.acceptor.begin_late(demand, step, missed as f64, self.together.is_some());
        begun.map_err(Fault::of_first_demand)?;
        self.mode = Mode::Moving { missed: u32::try_from(missed).unwrap_or(u32::MAX) };
        Ok(())
    }

    /// Whether a request came too late for its step, or did so in the run that is replayed: then what replaces its demand
    /// is found now.
    fn is_late(&mut self, step: u64) -> bool {
        let was_late = self.config.replayed.as_ref().is_some_and(|recorded| recorded.missed.contains(&step));
        if was_late && step >= self.due {
            self.next = Some(self.next_demand());
        }
        let is_late = was_late || step < self.due;
        if is_late {
            self.config.witnesses.show(self.host.waiter.now(), &What::Late { step }, &[]);
        }
        is_late
    }

    fn check_regulators(&self, sets: &Regulators) -> Result<(), Fault> {
        let drive = &self.config.drive;
        match (0..R::Joints::LEN).find(|&joint| !drive.has_regulator(joint, sets.set(joint))) {
            Some(joint) => {
                let text = format!("parameter set {}", sets.set(joint));
                Err(Fault::new(FaultKind::NoRegulator).at_joint(joint).text(&text))
            }
            None => Ok(()),
        }
    }

    fn answer(&mut self) {
        let at_standstill = self.is_at_standstill();
        let reply = &mut self.reply;
        (reply.header.epoch, reply.header.step) = (self.request.header.epoch, self.request.header.step);
        reply.header.instruction = self.request.header.instruction;
        reply.header.flags = 0;
        if at_standstill {
            reply.header.flags |= flag::STANDSTILL;
        }
        if let Some(fault) = &self.fault {
            reply.set_fault(fault);
        } else {
            reply.header.kind = Kind::Reply;
            reply.header.headroom = self.acceptor.headroom();
            reply.header.law = self.acceptor.braking_law(self.config.step.as_secs_f64());
            reply.header.len = 0;
            if self.request.is(flag::WANT_STATE) {
                reply.header.flags |= flag::STATE;
                reply.header.len = RobotImage::<R>::LEN as u32;
                let (q, v) = self.acceptor.demanded();
                let demanded = RobotState { joints: q, velocity: v, pose: self.acceptor.tool_pose(&q) };
                let q = self.measured.position;
                let measured = RobotState {
                    joints: q,
                    velocity: self.measured.velocity,
                    pose: self.acceptor.tool_pose(&q),
                };
                RobotImage::<R>::new(measured, demanded).put(&mut reply.body);
            }
        }
        self.port.reply(reply);
    }
}

/// What a request asks, as far as the gate is concerned.
const fn asked(request: RequestKind) -> Asked {
    match request {
        RequestKind::Demand => Asked::Move,
        RequestKind::Query | RequestKind::Brake => Asked::Look,
        RequestKind::Stop => Asked::Stop,
        RequestKind::Reset => Asked::Reset,
    }
}
