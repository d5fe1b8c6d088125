//! EDP: the effector driver process of one robot.
//!
//! In: demands of the ECP, one per step. Out: the joint positions that the drives get, one per servo period,
//! and the robot's image in every reply. Servo periods begin half a period after the steps, so that the demand of a step
//! is there before the drives ask for it; each gets the position for its end, interpolated in joints or in the task
//! space ([`Interpolation`]). The reply to a demand leaves as soon as the demand is accepted: the next one is computed
//! while the robot moves.

mod following;
mod resetting;
mod serving;
mod staying;
mod telling;
#[cfg(test)]
mod tests;

use crate::control::drive::Drive;
use crate::link::Host;
use crate::observe::servo::Observer;
use core::time::Duration;
use std::rc::Rc;

use crate::control::interpolation::Interpolation;
use crate::control::overruns::Overruns;
use crate::control::replay::RecordedRobot;
use crate::control::task_space::TaskSpace;
use crate::link::message::Message;
use crate::link::{Closed, Sample, Server, Waiter};
use crate::model::driver::{Measured, Regulators};
use crate::model::fault::{Fault, FaultKind, ProcessId};
use crate::model::joints::JointVector;
use crate::model::pose::Pose;
use crate::model::robot::InterpolationSpace;
use crate::model::robot::Robot;
use crate::model::time::Nanos;
use crate::observe::witness::Witnesses;
use crate::safety::braking::Braking;
use crate::safety::braking::BrakingLaw;
use crate::safety::latch::Gate;
use crate::safety::limits::{AcceptedDemand, Acceptor};
use crate::safety::screw::{Screw, ScrewBraking};
use crate::safety::stopping::detection_time;

/// How a robot is set up.
pub(crate) struct EdpConfig<R: Robot> {
    pub process: ProcessId,
    pub robot: R,
    pub drive: Drive<R>,
    pub tool: Pose,
    pub step: Duration,
    /// The cell's delay between demands and drives; `None`: drives take each demand as it is.
    pub delay: Option<Duration>,
    pub space: InterpolationSpace,
    /// Largest difference between demanded and measured joint positions [rad or m].
    pub following_error: R::Joints,
    /// Steps within which the robot must stand after a stop began.
    pub stop_steps: u64,
    pub observers: Vec<Observer<R>>,
    /// Where each step is shown.
    pub witnesses: Witnesses,
    /// What it replays.
    pub replayed: Option<Rc<RecordedRobot>>,
}

#[expect(clippy::large_enum_variant, reason = "a braking tail is a part of a step: it allocates nothing")]
enum Mode<J> {
    /// No demand is due.
    Holding,
    /// A demand is due in every step; those of so many steps are missing.
    Moving { missed: u32 },
    /// On the way to a standstill.
    Braking(Braking<J>),
    /// The same on the screw of robots that move together.
    OnScrew(ScrewBraking),
    /// The drives are without power and have their brakes applied: one gave up, or a fault stop is over.
    Off,
}

/// The process.
pub(crate) struct Edp<'w, R: Robot> {
    config: EdpConfig<R>,
    host: Host<'w>,
    port: Box<dyn Server>,
    acceptor: Acceptor<R>,
    mode: Mode<R::Joints>,
    /// Accepted for the step that is about to begin, and the regulators chosen with it.
    next: Option<AcceptedDemand<R>>,
    /// How the robot brakes with those that it moves together with, and the screw on which it does; known once a demand
    /// is missing.
    together: Option<BrakingLaw>,
    screw: Option<Screw>,
    regulators: Option<Regulators>,
    /// What the ticks make of the demands.
    interpolation: Interpolation<R::Joints>,
    task_space: TaskSpace<R::Joints>,
    /// What the drives were told last.
    commanded: R::Joints,
    /// The first step that has not begun here, and when it does; when the next servo period begins \[ns\].
    due: u64,
    next_step: Nanos,
    next_tick: Nanos,
    step: Nanos,
    servo: Nanos,
    /// Steps that were late, and for how many periods the last one was.
    overruns: Overruns,
    behind: u64,
    /// The last servo period was over before it could begin.
    left_out: bool,
    /// Steps for which the demands have stood still.
    still: u64,
    measured: Measured<R::Joints>,
    /// Shut by a stop or a fault.
    gate: Gate,
    fault: Option<Fault>,
    /// The driver has panicked: what it still does is unknown.
    lost: bool,
    request: Message,
    reply: Message,
}

impl<'w, R: Robot> Edp<'w, R> {
    pub fn new(config: EdpConfig<R>, host: Host<'w>, port: Box<dyn Server>) -> Self {
        let measured = config.drive.measured();
        let (step, servo) = (config.step.as_nanos() as Nanos, config.drive.period().as_nanos() as Nanos);
        let reaction = detection_time(config.step);
        let acceptor = Acceptor::new(config.robot.clone(), config.tool, measured.position, reaction);
        let (now, shorter) = (host.waiter.now(), servo.min(step));
        // Half a period after multiples of the period, from now on.
        let due = (now + step - shorter / 2).div_ceil(step.max(1)).saturating_sub(1);
        let tick = now.saturating_sub(servo / 2).div_ceil(servo.max(1));
        let interpolation = Interpolation::new(measured.position, due, config.step, config.delay);
        let mut edp = Edp {
            host,
            port,
            acceptor,
            mode: Mode::Holding,
            next: None,
            together: None,
            screw: None,
            regulators: None,
            still: interpolation.settling_steps(),
            interpolation,
            task_space: TaskSpace::new(),
            commanded: measured.position,
            due,
            next_step: due * step + shorter / 2,
            next_tick: tick * servo + servo / 2,
            step,
            servo,
            overruns: Overruns::new(config.step),
            behind: 0,
            left_out: false,
            measured,
            gate: Gate::default(),
            fault: None,
            lost: false,
            request: Message::empty(),
            reply: Message::empty(),
            config,
        };
        // Where encoders give no numbers, there is nothing to hold: the drives get no demand at all.
        if let Err(fault) = edp.check_following(edp.interpolation.goal(), FaultKind::FollowingError) {
            edp.mode = Mode::Off;
            edp.latch(fault, 0);
        }
        edp
    }

    /// The same behind the gate that was kept while the robot looked for its marks.
    pub fn behind(mut self, gate: Gate) -> Self {
        self.gate = gate;
        self
    }

    /// Keeps the first fault.
    fn latch(&mut self, fault: Fault, step: u64) {
        self.gate = self.gate.closed();
        if self.fault.is_none() {
            let fault = fault.in_process(self.config.process).at_step(step);
            self.tell_fault(&fault, step);
            self.fault = Some(fault);
        }
    }

    /// Serves until the cell closes.
    ///
    /// # Errors
    /// `PeerLost` when the robot still moved then and did not come to a standstill in the time that its stops may take.
    pub fn run(mut self) -> Result<(), Fault> {
        while self.host.waiter.wait(Some(self.next_step.min(self.next_tick))) != Err(Closed) {
            let (woke, first) = (self.host.waiter.now(), self.next_tick);
            while self.port.receive(&mut self.request) {
                self.serve();
            }
            while self.host.waiter.now() >= self.next_step.min(self.next_tick) {
                self.advance();
            }
            if self.next_tick > first {
                self.host.meter.sample(Sample::Worked(self.host.waiter.now().saturating_sub(woke)));
            }
        }
        self.come_to_rest()
    }

    /// Brakes what still moves when the cell closes: its other processes may be gone. Where time stands still then,
    /// nothing moves.
    fn come_to_rest(&mut self) -> Result<(), Fault> {
        self.gate = self.gate.closed();
        self.brake();
        let began = self.due;
        let last = began + self.config.stop_steps;
        // The demand that holds is one of the next step, and the drives are there at the end of that step. They stay where
        // they were told to be last: that period is not one that is left out.
        while !self.is_at_standstill() || self.due <= began + 2 || self.left_out {
            if self.due > last {
                if self.is_at_standstill() {
                    return Ok(());
                }
                let text = "the cell closed while the robot moved, and it does not come to a standstill";
                return Err(Fault::new(FaultKind::PeerLost).in_process(self.config.process).text(text));
            }
            let next = self.next_step.min(self.next_tick);
            if self.host.waiter.wait_closing(next).is_err() {
                return Ok(());
            }
            while self.host.waiter.now() >= self.next_step.min(self.next_tick) {
                self.advance();
            }
        }
        Ok(())
    }

    /// The step or servo period that begins next; a step before the servo period that begins with it.
    ///
    /// A step that is late is made up for: what its demand was, or what bridged it, is what the next one begins at. A servo
    /// period that is over is left out: drives are told where to be at the end of the present one, on the same curve.
    fn advance(&mut self) {
        let now = self.host.waiter.now();
        if self.next_step <= self.next_tick {
            self.count_late_step(now);
            self.begin_step();
            self.next_step += self.step;
            return;
        }
        if now >= self.next_tick + self.servo {
            self.host.meter.sample(Sample::Skipped(1));
            self.left_out = true;
        } else {
            self.left_out = false;
            self.host.meter.sample(Sample::Late(now.saturating_sub(self.next_tick)));
            self.tick(self.next_tick);
        }
        self.next_tick += self.servo;
    }

    /// Being late is one cause, however many steps are made up for at once. It counts while the robot moves.
    fn count_late_step(&mut self, now: Nanos) {
        let missed = now.saturating_sub(self.next_step) / self.step.max(1);
        let goes_on = missed + 1 == core::mem::replace(&mut self.behind, missed);
        if goes_on || !matches!(self.mode, Mode::Moving { .. }) {
            return;
        }
        if let Err(fault) = self.overruns.note(missed) {
            self.latch(fault, self.due);
            self.brake();
        }
    }

    fn check_following(&self, demanded: &R::Joints, kind: FaultKind) -> Result<(), Fault> {
        for i in 0..R::Joints::LEN {
            let (error, limit) =
                ((self.measured.position[i] - demanded[i]).abs(), self.config.following_error[i]);
            // A NaN from an encoder is no small error.
            let is_small = error <= limit && self.measured.velocity[i].is_finite();
            if !is_small {
                return Err(Fault::new(kind).at_joint(i).exceeds(
                    error,
                    limit,
                    self.config.robot.joint(i).unit(0),
                ));
            }
        }
        Ok(())
    }

    fn brake(&mut self) {
        match self.mode {
            Mode::Moving { .. } => self.mode = self.way_to_rest(),
            Mode::Holding if !self.acceptor.is_at_its_end() => self.mode = self.way_to_rest(),
            Mode::Holding | Mode::Braking(_) | Mode::OnScrew(_) | Mode::Off => {}
        }
    }

    /// Whether the robot stands, and its drives have come to the last demand.
    fn is_at_standstill(&self) -> bool {
        match self.mode {
            Mode::Holding => {
                self.acceptor.is_at_its_end() && self.still >= self.interpolation.settling_steps()
            }
            Mode::Off => true,
            Mode::Moving { .. } | Mode::Braking(_) | Mode::OnScrew(_) => false,
        }
    }
}
