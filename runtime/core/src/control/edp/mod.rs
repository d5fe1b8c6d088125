//! EDP: the effector driver process of one robot.
//!
//! In: demands of the ECP, one per step. Out: the joint positions that the drives get, one per servo period,
//! and the robot's image in every reply. Servo periods begin half a period after the steps, so that the demand of a step
//! is there before the drives ask for it; each gets the position for its end, interpolated in joints or in the task
//! space. Servo periods of a robot that paces itself begin when it says so, at any phase to the steps, and get the positions
//! for their own ends. The reply to a demand leaves as soon as the demand is accepted: the next one is computed while the
//! robot moves.
//!
//! Its parts own their state: [`answers`] is the ECP's side, [`path`] the demands and what replaces them, [`servo`] the drives,
//! [`signals`] its inputs and outputs, [`clock`] the time, [`shown`] those who watch, [`stop_asked`] a stop that the MP does not begin. What takes all of them is here, in [`serving`], [`stepping`] and
//! [`resetting`].

mod answers;
mod clock;
mod path;
mod phase_lock;
mod resetting;
mod serving;
mod servo;
mod shown;
pub(crate) mod signals;
mod stepping;
mod stop_asked;
#[cfg(test)]
mod tests;

use core::time::Duration;
use std::rc::Rc;

use crate::control::drive::Drive;
use crate::control::guarded::guarded;
use crate::control::replay::RecordedRobot;
use crate::link::{Board, Host, Sample, Server};
use crate::model::fault::{Fault, FaultKind, ProcessId};
use crate::model::pose::Pose;
use crate::model::robot::{InterpolationSpace, Robot};
use crate::model::time::Nanos;
use crate::observe::servo::Observer;
use crate::observe::step_observer::StepObservers;
use crate::safety::latch::Gate;

use answers::Answers;
use clock::{Period, ServoClock};
use path::{DemandedPath, Mode};
use servo::{Servo, Timing};
use shown::Shown;
use signals::{Declared, SignalPort};
use stop_asked::StopAsked;

/// How a robot is set up.
pub(crate) struct EdpConfig<R: Robot> {
    pub process: ProcessId,
    pub robot: R,
    pub drive: Drive<R>,
    pub tool: Pose,
    /// Length of a step.
    pub period: Duration,
    /// The cell's delay between demands and drives; `None`: drives take each demand as it is.
    pub delay: Option<Duration>,
    pub space: InterpolationSpace,
    /// Largest difference between demanded and measured joint positions [rad or m].
    pub following_error: R::Joints,
    /// Steps within which the robot must stand after a stop began.
    pub stop_steps: u64,
    pub declared: Declared,
    pub observers: Vec<Observer<R>>,
    /// Where each step is shown.
    pub step_observers: StepObservers,
    /// Where the measured state is shown to virtual sensors of this robot that others read.
    pub states: Vec<Rc<dyn Board>>,
    /// What it replays.
    pub replayed: Option<Rc<RecordedRobot>>,
}

/// The process: what it answers its ECP, the demands that it follows, its drives, and who watches.
pub(crate) struct Edp<'w, R: Robot> {
    host: Host<'w>,
    answers: Answers,
    path: DemandedPath<R>,
    servo: Servo<R>,
    signals: SignalPort,
    clock: ServoClock,
    shown: Shown<R>,
    stop_asked: StopAsked,
    /// Steps within which the robot must stand after a stop began.
    stop_steps: u64,
    /// What it replays.
    replayed: Option<Rc<RecordedRobot>>,
    /// The last request waits for the step in which it came in the run that is replayed.
    is_held_back: bool,
}

impl<'w, R: Robot> Edp<'w, R> {
    pub fn new(config: EdpConfig<R>, host: Host<'w>, port: Box<dyn Server>) -> Self {
        let period = config.period;
        let clock = ServoClock::new(host.waiter.now(), period, config.drive.period(), config.drive.pace());
        let timing = Timing { due: clock.due, period, delay: config.delay };
        let servo = Servo::new(config.drive, config.space, config.following_error, &timing);
        let mut edp = Edp {
            host,
            answers: Answers::new(config.process, port),
            path: DemandedPath::new(config.robot, config.tool, servo.commanded, period),
            servo,
            signals: SignalPort::new(config.declared, period, config.delay),
            clock,
            shown: Shown {
                observers: config.observers,
                step_observers: config.step_observers,
                states: config.states,
            },
            stop_asked: StopAsked::new(period),
            stop_steps: config.stop_steps,
            replayed: config.replayed,
            is_held_back: false,
        };
        // Where encoders give no numbers, there is nothing to hold: the drives get no demand at all.
        let unread = || edp.check_following(edp.servo.interpolation.goal(), FaultKind::FollowingError).err();
        if let Some(fault) = edp.servo.drive.unopened().cloned().or_else(unread) {
            edp.path.mode = Mode::Off;
            edp.latch(fault, 0);
        }
        edp
    }

    /// The same behind the gate that was kept while the robot looked for its marks.
    pub fn behind(mut self, gate: Gate) -> Self {
        self.answers.gate = gate;
        self
    }

    /// Keeps the first fault. Outputs take the values of a stop.
    fn latch(&mut self, fault: Fault, step: u64) {
        self.stop_outputs(step);
        if let Some(fault) = self.answers.latch(fault, step) {
            self.shown.show_fault(self.host.waiter.now(), fault, step);
        }
    }

    /// Gives outputs the values that the cell declares for a stop. A driver that panics at that is the fault, unless there is
    /// one already.
    fn stop_outputs(&mut self, step: u64) {
        if let Err(panic) = self.signals.stop(&mut self.servo)
            && let Some(fault) = self.answers.latch(panic, step)
        {
            self.shown.show_fault(self.host.waiter.now(), fault, step);
            self.path.brake();
        }
    }

    /// Keeps the first fault, and brings the robot to a standstill.
    fn stop_for(&mut self, fault: Fault, step: u64) {
        self.latch(fault, step);
        self.path.brake();
    }

    /// Serves until the cell closes.
    ///
    /// # Errors
    /// `PeerLost` when the robot still moved then and did not come to a standstill in the time that its stops may take.
    pub fn run(mut self) -> Result<(), Fault> {
        let waiter = self.host.waiter;
        waiter.serve(self.clock.next(), &mut || self.turn());
        let rest = self.come_to_rest();
        // What a driver does when it is let go moves nothing, and no robot waits for it.
        let closed = guarded(|| self.servo.drive.close());
        rest.and(closed)
    }

    /// Serves what has been asked for, and begins the steps and servo periods that are due. When the next one begins \[ns\].
    fn turn(&mut self) -> Nanos {
        let woke = self.host.waiter.now();
        let first = self.clock.next_tick;
        self.serve_requests();
        loop {
            let now = self.host.waiter.now();
            if now < self.clock.next() {
                break;
            }
            self.advance(now);
            if self.is_held_back {
                self.serve_requests();
            }
        }
        if self.clock.next_tick > first {
            self.host.meter.sample(Sample::Worked(self.host.waiter.now().saturating_sub(woke)));
        }
        self.clock.next()
    }

    /// Brakes what still moves when the cell closes: its other processes may be gone. Where time stands still then,
    /// nothing moves.
    fn come_to_rest(&mut self) -> Result<(), Fault> {
        self.answers.shut();
        self.stop_outputs(self.clock.due);
        self.path.brake();
        let began = self.clock.due;
        let last = began + self.stop_steps;
        // The demand that holds is one of the next step, and the drives are there at the end of that step. They stay where
        // they were told to be last: that period is not one that is left out.
        while !self.is_at_standstill() || self.clock.due <= began + 2 || self.clock.left_out {
            if self.clock.due > last {
                if self.is_at_standstill() {
                    return Ok(());
                }
                let text = "the cell closed while the robot moved, and it does not come to a standstill";
                let lost = Fault::new(FaultKind::PeerLost).in_process(self.answers.process());
                return Err(lost.text(text));
            }
            if self.host.waiter.wait_closing(self.clock.next()).is_err() {
                return Ok(());
            }
            while self.host.waiter.now() >= self.clock.next() {
                self.advance(self.host.waiter.now());
            }
        }
        Ok(())
    }

    /// The step or servo period that begins next; a step before the servo period that begins with it.
    ///
    /// A step that is late is made up for: what its demand was, or what bridged it, is what the next one begins at. A servo
    /// period that is over is left out: drives are told where to be at the end of the present one, on the same curve.
    fn advance(&mut self, now: Nanos) {
        if self.clock.next_step <= self.clock.next_tick {
            // To be late counts while the robot moves.
            if let Err(fault) = self.clock.count_late_step(now, self.path.is_moving()) {
                self.stop_for(fault, self.clock.due);
            }
            self.begin_step();
            self.clock.end_step();
            return;
        }
        if self.clock.is_paced_by_robot() {
            let pulse = self.pulse(now);
            if let Some(period) = self.clock.told_period(now, pulse) {
                self.begin_period(period);
            }
            return;
        }
        match self.clock.next_period(now) {
            Some(period) => self.begin_period(period),
            None => self.host.meter.sample(Sample::Skipped(1)),
        }
    }

    fn begin_period(&mut self, period: Period) {
        if period.lost > 0 {
            self.host.meter.sample(Sample::Skipped(period.lost));
        }
        self.host.meter.sample(Sample::Late(period.late));
        self.tick(period);
    }

    /// Whether the joints are where they were told to be.
    fn check_following(&self, demanded: &R::Joints, kind: FaultKind) -> Result<(), Fault> {
        self.servo.check_following(self.path.acceptor.robot(), demanded, kind)
    }

    /// Whether the robot stands, and its drives have come to the last demand, and switched what was demanded with it.
    fn is_at_standstill(&self) -> bool {
        self.path.is_off()
            || self.path.is_at_its_end() && self.servo.has_settled() && self.signals.has_switched()
    }
}
