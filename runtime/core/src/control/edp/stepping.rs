//! What an EDP does when a step, or a servo period, begins.
//!
//! In: accepted demands, or none. Out: what the drives are told, what the encoders say; the faults of drives, of joints that
//! do not follow, of demands that stay away.

use crate::control::guarded::guarded;
use crate::model::fault::{Fault, FaultKind};
use crate::model::image::RobotState;
use crate::model::joints::{JointVector, MAX_JOINTS};
use crate::model::pace::Pulse;
use crate::model::robot::Robot;
use crate::model::robot_stop::{RobotStop, StopCause};
use crate::model::signals::SIGNAL_WORDS;
use crate::model::time::Nanos;
use crate::model::wire::Wire;
use crate::observe::servo::ServoRecord;
use crate::observe::step_observer::StepEvent;
use crate::operator::state::EdpState;
use crate::safety::limits::AcceptedDemand;

use super::Edp;
use super::clock::Period;
use super::path::Mode;
use super::shown::{image_words, shown_mode};

impl<R: Robot> Edp<'_, R> {
    /// A step begins: its demand, or what replaces it, is what the drives are on their way to.
    pub(super) fn begin_step(&mut self) {
        if self.stop_asked.is_overdue(self.clock.due, self.host.stops) && self.answers.fault.is_none() {
            self.stop_for(Fault::of_operator(), self.clock.due);
        }
        if !self.path.is_off() {
            let demand = *self.next_demand().joints();
            let told = self.servo.begin_step(demand);
            if let Err(panic) = told.and_then(|()| self.signals.begin_step(self.clock.due, &mut self.servo)) {
                self.path.mode = Mode::Off;
                self.latch(panic, self.clock.due);
            }
        }
        self.show_step();
        self.show_to_operator();
        self.show_state();
        self.clock.due += 1;
    }

    /// The demand of the step that begins: the one that came, or what replaces it.
    pub(super) fn next_demand(&mut self) -> AcceptedDemand<R> {
        if let Err(fault) = self.path.count_missing() {
            self.stop_for(fault, self.clock.due);
        }
        self.path.next_demand()
    }

    /// One servo period.
    #[allow(non_snake_case)]
    pub(super) fn tick(&mut self, period: Period) {
        if self.path.is_off() {
            if let Err(panic) = self.servo.stand_by(period.begins) {
                self.latch(panic, self.clock.step_at(period.begins));
            }
            return;
        }
        let switched = self.signals.tick(period.ends, &mut self.servo);
        let demanded = self.position_at(period.ends);
        let X_FE = *self.path.acceptor.tool();
        let fault = match self.servo.tick(period.begins, &demanded, &X_FE, self.host.waiter) {
            Ok(followed) => self.check_following(&followed, FaultKind::FollowingError).err(),
            Err(fault) => {
                self.path.mode = Mode::Off;
                Some(fault)
            }
        };
        let looked = switched.and_then(|()| self.signals.look(&mut self.servo));
        let observed = self.show_servo(period.ends, demanded).and(looked);
        if let Some(fault) = fault.or(observed.err()) {
            self.stop_for(fault, self.clock.step_at(period.begins));
        }
    }

    /// Whether the robot has told the beginning of a servo period. One that says nothing for too long has stopped by itself.
    pub(super) fn pulse(&mut self, now: Nanos) -> Option<Pulse> {
        let pulse = self.servo.pulse(now);
        let silent = self.clock.silent_for(now).filter(|_| matches!(pulse, Ok(None)));
        let fault = match (pulse, silent) {
            (Ok(pulse), None) => return pulse,
            (Ok(_), Some(silent)) => {
                let lost = RobotStop::new(StopCause::CommunicationLost);
                let text = format!("{lost}: the robot has said nothing for {:.0} ms", silent as f64 * 1e-6);
                Fault::of_robot_stop(&lost).text(&text)
            }
            (Err(fault), _) => fault,
        };
        // Without power it may say what it likes; a reset hears it again.
        if !self.path.is_off() {
            self.path.mode = Mode::Off;
            self.stop_for(fault, self.clock.step_at(now));
        }
        None
    }

    /// What the drives are told for the end of a servo period.
    fn position_at(&mut self, end: Nanos) -> R::Joints {
        let joints = self.servo.interpolation.at(end);
        if !self.servo.is_in_task_space() {
            return joints;
        }
        let learned =
            self.servo.learn_difference(end, &joints, self.clock.servo_period(), &self.path.acceptor);
        if let Err(fault) = learned {
            self.stop_for(fault, self.clock.due.saturating_sub(1));
        }
        joints + self.servo.task_space.correction()
    }

    /// Shows the servo period to the observers.
    fn show_servo(&mut self, end: Nanos, demanded: R::Joints) -> Result<(), Fault> {
        if !self.shown.is_observed() {
            return Ok(());
        }
        self.shown.show_servo(&ServoRecord {
            time: end as f64 * 1e-9,
            demanded,
            measured: self.servo.measured,
            tool: *self.path.acceptor.tool(),
        })
    }

    /// Shows the step that begins to the observers.
    fn show_step(&mut self) {
        if !self.shown.step_observers.is_watched() {
            return;
        }
        let what = StepEvent::Image { step: self.clock.due, mode: shown_mode(&self.path.mode) };
        // Kinematics are the user's code.
        match guarded(|| image_words(&self.path.acceptor, &self.measured_state())) {
            Ok(words) => self.shown.step_observers.show(self.host.waiter.now(), &what, &words),
            Err(panic) => self.stop_for(panic, self.clock.due),
        }
        self.show_currents();
        self.show_signals();
    }

    /// Shows them what the motors take, if the drives measure it. Of drives that panicked nothing more is asked.
    fn show_currents(&mut self) {
        if self.servo.lost {
            return;
        }
        match guarded(|| self.servo.drive.motor_currents()) {
            Ok(None) => {}
            Ok(Some(currents)) => {
                let mut words = [0; MAX_JOINTS];
                for (word, current) in words.iter_mut().zip(currents.as_slice()) {
                    *word = current.to_bits();
                }
                let what = StepEvent::Currents { step: self.clock.due };
                self.shown.step_observers.show(self.host.waiter.now(), &what, &words[..R::Joints::LEN]);
            }
            Err(panic) => self.stop_for(panic, self.clock.due),
        }
    }

    /// Shows them the robot's inputs and outputs, if it has any.
    fn show_signals(&self) {
        if self.signals.has_any() {
            let mut words = [0; SIGNAL_WORDS];
            self.signals.signals().put(&mut words);
            let what = StepEvent::Signals { step: self.clock.due };
            self.shown.step_observers.show(self.host.waiter.now(), &what, &words);
        }
    }

    /// Shows the operator what the robot carries, and its inputs and outputs.
    fn show_to_operator(&self) {
        self.host.console.show_edp(&EdpState {
            tool: self.path.acceptor.tool(),
            load: self.signals.carried(),
            signals: self.signals.signals(),
        });
    }

    /// Shows the measured state to virtual sensors.
    fn show_state(&mut self) {
        if self.shown.states.is_empty() {
            return;
        }
        match guarded(|| self.measured_state()) {
            Ok(state) => self.shown.show_state(self.clock.due, &state),
            Err(panic) => self.stop_for(panic, self.clock.due),
        }
    }

    /// What the encoders read last, and the pose of the tool there.
    pub(super) fn measured_state(&self) -> RobotState<R> {
        let measured = &self.servo.measured;
        let pose = self.path.acceptor.tool_pose(&measured.position);
        RobotState { joints: measured.position, velocity: measured.velocity, pose }
    }
}
