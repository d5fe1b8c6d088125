//! Who watches an EDP: observers of its servo periods, observers of its steps and faults, and virtual sensors.
//!
//! In: servo periods, steps that begin, the fault that it stops for. Out: the same to those who watch; nothing that the EDP
//! acts on.

use std::rc::Rc;

use crate::control::guarded::guarded;
use crate::link::Board;
use crate::link::message::{Kind, Message};
use crate::model::fault::Fault;
use crate::model::image::{RobotState, STATE_WORDS};
use crate::model::robot::Robot;
use crate::model::time::Nanos;
use crate::model::wire::Wire;
use crate::observe::servo::{Observer, ServoRecord};
use crate::observe::step_observer::{IMAGE_WORDS, Mode as ShownMode, StepEvent, StepObservers};
use crate::safety::limits::Acceptor;

use super::path::Mode;

/// Those who watch.
pub(super) struct Shown<R: Robot> {
    pub observers: Vec<Observer<R>>,
    pub step_observers: StepObservers,
    pub states: Vec<Rc<dyn Board>>,
}

impl<R: Robot> Shown<R> {
    /// Whether servo periods are observed.
    pub fn is_observed(&self) -> bool {
        !self.observers.is_empty()
    }

    /// Shows a servo period to the observers. One that panics ends them all.
    ///
    /// # Errors
    /// Its panic.
    pub fn show_servo(&mut self, record: &ServoRecord<R>) -> Result<(), Fault> {
        let observers = &mut self.observers;
        let shown = guarded(|| observers.iter_mut().for_each(|observer| observer(record)));
        if shown.is_err() {
            observers.clear();
        }
        shown
    }

    /// Shows the measured state to the virtual sensors that want it.
    pub fn show_state(&self, step: u64, state: &RobotState<R>) {
        let mut message = Message::new(Kind::Read);
        message.header.step = step;
        message.header.len = STATE_WORDS as u32;
        state.put(&mut message.body);
        self.states.iter().for_each(|board| board.write(&message));
    }

    /// Shows that a request came too late for its step: demands could be taken for step `due`.
    pub fn show_late(&self, now: Nanos, step: u64, nth: u32, due: u64) {
        self.step_observers.show(now, &StepEvent::LateRequest { step, nth, due }, &[]);
    }

    /// Shows the fault that is latched.
    pub fn show_fault(&self, now: Nanos, fault: &Fault, step: u64) {
        self.step_observers.show_fault(now, &StepEvent::Fault { step }, Some(fault));
    }
}

/// What is shown of a mode.
pub(super) const fn shown_mode<J>(mode: &Mode<J>) -> ShownMode {
    match mode {
        Mode::Holding => ShownMode::Holding,
        Mode::Moving { missed: 0 } => ShownMode::Moving,
        Mode::Moving { .. } => ShownMode::Bridging,
        Mode::Braking(_) | Mode::OnTwist(_) => ShownMode::Braking,
        Mode::Off => ShownMode::Off,
    }
}

/// A step that begins, in words: its demand, what the encoders had read, the tool.
pub(super) fn image_words<R: Robot>(acceptor: &Acceptor<R>, measured: &RobotState<R>) -> [u64; IMAGE_WORDS] {
    let mut words = [0; IMAGE_WORDS];
    // What its drives are told, which is not where the path is after late demands.
    let (joints, velocity) = acceptor.accepted();
    let demanded = RobotState::<R> { joints, velocity, pose: acceptor.tool_pose(&joints) };
    demanded.put(&mut words);
    measured.put(&mut words[STATE_WORDS..]);
    acceptor.tool().put(&mut words[2 * STATE_WORDS..]);
    words
}
