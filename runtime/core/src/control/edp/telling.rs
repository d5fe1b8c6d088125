//! What an EDP tells those who watch: each step as it begins, and the fault that it stops for.
//!
//! In: a step that begins. Out: its demand, what the encoders had read, the tool, as words of an image.

use crate::model::fault::Fault;
use crate::model::image::{RobotState, STATE_WORDS};
use crate::model::robot::Robot;
use crate::model::wire::Wire;
use crate::observe::witness::{IMAGE_WORDS, Mode as Shown, What};

use crate::control::guarded::guarded;

use super::{Edp, Mode};

impl<R: Robot> Edp<'_, R> {
    /// The step that begins.
    pub(super) fn tell_step(&mut self) {
        if !self.config.witnesses.is_watched() {
            return;
        }
        let mode = match self.mode {
            Mode::Holding => Shown::Holding,
            Mode::Moving { missed: 0 } => Shown::Moving,
            Mode::Moving { .. } => Shown::Bridging,
            Mode::Braking(_) | Mode::OnScrew(_) => Shown::Braking,
            Mode::Off => Shown::Off,
        };
        // Kinematics are the user's code.
        match guarded(|| self.image_words()) {
            Ok(words) => {
                self.config.witnesses.show(
                    self.host.waiter.now(),
                    &What::Image { step: self.due, mode },
                    &words,
                );
            }
            Err(panic) => {
                self.latch(panic, self.due);
                self.brake();
            }
        }
    }

    fn image_words(&self) -> [u64; IMAGE_WORDS] {
        let mut words = [0; IMAGE_WORDS];
        // What its drives are told, which is not where the path is after late demands.
        let (q, v) = self.acceptor.accepted();
        let demanded = RobotState::<R> { joints: q, velocity: v, pose: self.acceptor.tool_pose(&q) };
        let (q, v) = (self.measured.position, self.measured.velocity);
        let measured = RobotState::<R> { joints: q, velocity: v, pose: self.acceptor.tool_pose(&q) };
        demanded.put(&mut words);
        measured.put(&mut words[STATE_WORDS..]);
        self.acceptor.tool().put(&mut words[2 * STATE_WORDS..]);
        words
    }

    /// The fault that is latched.
    pub(super) fn tell_fault(&self, fault: &Fault, step: u64) {
        self.config.witnesses.show_fault(self.host.waiter.now(), &What::Fault { step }, Some(fault));
    }
}
