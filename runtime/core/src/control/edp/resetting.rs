//! What an EDP does between a stop and the demands after a reset.
//!
//! In: a robot that stands, latched. Out: the same robot, whose demands begin where it is; nothing has moved.

use crate::control::interpolation::Interpolation;
use crate::control::task_space::TaskSpace;
use crate::model::driver::Regulators;
use crate::model::fault::{Fault, FaultKind};
use crate::model::robot::Robot;
use crate::safety::limits::Acceptor;
use crate::safety::stopping::detection_time;

use crate::control::guarded::guarded;

use super::{Edp, Mode};

impl<R: Robot> Edp<'_, R> {
    /// A fault stop is over when the robot stands: power off, brakes on, where the drives have such.
    pub(super) fn switch_off(&mut self) {
        let holds = matches!(self.mode, Mode::Holding) && self.is_at_standstill();
        if holds && self.config.drive.has_brakes() {
            self.mode = Mode::Off;
            if let Err(panic) = guarded(|| self.config.drive.switch_off(self.host.waiter)) {
                self.lost = true;
                self.latch(panic, self.request.header.step);
            }
        }
    }

    /// Leaves the latch. Drives without power come on where the robot is. One that held all the time goes on holding what
    /// it was told last, so that a gripper keeps its grip, unless it does not follow: then it, too, begins where it is.
    ///
    /// # Errors
    /// What is still wrong: the robot stays latched.
    pub(super) fn reset(&mut self) -> Result<(), Fault> {
        self.overruns.forget();
        let before = self.fault.take();
        if self.lost {
            return Err(before.unwrap_or_else(|| Fault::new(FaultKind::GeneratorPanicked)));
        }
        let was_off = matches!(self.mode, Mode::Off);
        if was_off {
            guarded(|| self.power())??;
        }
        let goal = *self.interpolation.goal();
        let follows = self.check_following(&goal, FaultKind::FollowingError).is_ok();
        let position = if follows && !was_off { goal } else { self.measured.position };
        // Where encoders give no numbers there is nowhere to begin.
        self.check_following(&position, FaultKind::FollowingError)?;
        self.begin_at(position);
        Ok(())
    }

    /// Power for drives that have none, with the regulators that they began with.
    fn power(&mut self) -> Result<(), Fault> {
        let drive = &mut self.config.drive;
        drive.switch_on(self.host.waiter)?;
        drive.choose_regulators(&Regulators::default());
        self.measured = drive.measured();
        Ok(())
    }

    /// Holds a position, as a robot does that has just been set up there.
    fn begin_at(&mut self, position: R::Joints) {
        let (step, delay) = (self.config.step, self.config.delay);
        let reaction = detection_time(step);
        self.acceptor = Acceptor::new(self.config.robot.clone(), self.config.tool, position, reaction);
        self.interpolation = Interpolation::new(position, self.due, step, delay);
        self.task_space = TaskSpace::new();
        self.commanded = position;
        self.still = self.interpolation.settling_steps();
        self.mode = Mode::Holding;
        (self.next, self.regulators, self.together, self.screw) = (None, None, None, None);
    }
}
