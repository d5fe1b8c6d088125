//! What an EDP does between a stop and the demands after a reset.
//!
//! In: a robot that stands, latched. Out: the same robot, whose demands begin where it is; nothing has moved.

use crate::control::guarded::guarded;
use crate::link::message::flag;
use crate::model::driver::Recovery;
use crate::model::fault::{Fault, FaultKind};
use crate::model::joints::JointVector;
use crate::model::robot::Robot;

use super::Edp;
use super::path::Mode;

impl<R: Robot> Edp<'_, R> {
    /// A fault stop is over when the robot stands: power off, brakes on, where the drives have such.
    pub(super) fn switch_off(&mut self) {
        let holds = matches!(self.path.mode, Mode::Holding) && self.is_at_standstill();
        if holds && self.servo.drive.has_brakes() {
            self.path.mode = Mode::Off;
            if let Err(panic) = self.servo.switch_off(self.host.waiter) {
                self.latch(panic, self.answers.request.header.step);
            }
        }
    }

    /// Lets a robot without power do what it needs after a stop of its own, if it is its turn. What it refuses is what a
    /// reset fails with.
    pub(super) fn recover(&mut self) {
        self.answers.recovers = false;
        if !self.answers.request.is(flag::RECOVER) || !self.path.is_off() || self.servo.lost {
            return;
        }
        match guarded(|| self.servo.drive.recover()) {
            Ok(Ok(recovery)) => self.answers.recovers = recovery == Recovery::GoesOn,
            Ok(Err(_)) => {}
            Err(panic) => {
                self.servo.lost = true;
                self.latch(panic, self.answers.request.header.step);
            }
        }
    }

    /// Leaves the latch. Drives without power come on where the robot is. One that held all the time goes on holding what
    /// it was told last, so that a gripper keeps its grip, unless it does not follow: then it, too, begins where it is.
    ///
    /// # Errors
    /// What is still wrong: the robot stays latched.
    pub(super) fn reset(&mut self) -> Result<(), Fault> {
        self.clock.forget(self.host.waiter.now());
        let before = self.answers.fault.take();
        if self.servo.lost {
            return Err(before.unwrap_or_else(|| Fault::new(FaultKind::Panicked)));
        }
        let was_off = self.path.is_off();
        if was_off {
            guarded(|| self.servo.switch_on(self.host.waiter))??;
        }
        let goal = *self.servo.interpolation.goal();
        let follows = self.check_following(&goal, FaultKind::FollowingError).is_ok();
        // Recorded drives have no power to lose: the run that is replayed knows where it began.
        let recorded = self.replayed.as_ref().and_then(|run| run.image(self.clock.due));
        let position = match recorded {
            Some(image) => R::Joints::from_joints(|i| image.demanded[i]),
            None if follows && !was_off => goal,
            None => self.servo.rest(),
        };
        // Where encoders give no numbers there is nowhere to begin.
        self.check_following(&position, FaultKind::FollowingError)?;
        if was_off {
            self.signals.tell_again();
        }
        self.path.begin_at(position);
        self.servo.begin_at(position, self.clock.due);
        Ok(())
    }
}
