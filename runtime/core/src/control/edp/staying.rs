//! How a robot stays with those that it moves together with when its demands stay away, and how any robot comes to rest.
//!
//! In: the braking law of the last order, the screw of the last step. Out: accepted demands on that screw; where a limit or
//! the kinematics forbids it, in joint space.

use crate::model::pose::Pose;
use crate::model::robot::Robot;
use crate::safety::limits::AcceptedDemand;
use crate::safety::screw::{Screw, ScrewBraking};
use crate::safety::stopping::{TOGETHER_BUDGET, missed_step_budget};

use crate::control::guarded::guarded;

use super::{Edp, Mode};

impl<R: Robot> Edp<'_, R> {
    /// Missing demands that are bridged.
    pub(super) fn missed_step_budget(&self) -> u32 {
        if self.together.is_some() { TOGETHER_BUDGET } else { missed_step_budget(self.config.step) }
    }

    /// What replaces a demand that is missing: along the screw, or at the joints' velocity.
    pub(super) fn bridge(&mut self, step: f64) -> AcceptedDemand<R> {
        if self.together.is_some() && self.acceptor.stands() {
            return self.acceptor.stand_by(step);
        }
        if let Some(screw) = self.learn_screw(step)
            && let Ok(Ok(accepted)) = guarded(|| self.acceptor.go_on(&screw.part(1.0), step))
        {
            return accepted;
        }
        self.together = None;
        self.acceptor.extrapolate(step)
    }

    /// The next state on the way to a standstill on the screw.
    #[allow(non_snake_case)]
    pub(super) fn slow_down(&mut self, D: &Pose, step: f64) -> AcceptedDemand<R> {
        if let Ok(Ok(accepted)) = guarded(|| self.acceptor.slow_down(D, step)) {
            return accepted;
        }
        let mut braking = self.acceptor.braking();
        let accepted = self.acceptor.brake(&mut braking, step);
        self.mode = Mode::Braking(braking);
        accepted
    }

    /// The robot stays where it was demanded last, and comes there first where it is not.
    pub(super) fn hold(&mut self, step: f64) -> AcceptedDemand<R> {
        let held = self.acceptor.hold(step);
        self.mode = match held {
            Ok(_) => Mode::Holding,
            Err(_) => Mode::Braking(self.acceptor.braking()),
        };
        held.unwrap_or_else(|_| self.next_demand())
    }

    /// A motion ends, or its path time stands still: a robot that may hold does, so that it is where the path is.
    pub(super) fn come_to_hold(&mut self) {
        match self.mode {
            Mode::Moving { .. } if self.acceptor.can_hold(self.config.step.as_secs_f64()) => {
                self.mode = Mode::Holding;
            }
            Mode::Moving { .. } => self.brake(),
            Mode::Holding | Mode::Braking(_) | Mode::OnScrew(_) | Mode::Off => {}
        }
    }

    /// The way to a standstill from the state demanded last.
    pub(super) fn way_to_rest(&mut self) -> Mode<R::Joints> {
        let step = self.config.step.as_secs_f64();
        // Where the law lets all robots stand in the next step, none goes on for the others' sake.
        if let Some(law) = self.together.filter(|law| !law.stops_at_once(step))
            && let Some(screw) = self.learn_screw(step)
        {
            return Mode::OnScrew(ScrewBraking::new(screw, law));
        }
        if self.acceptor.stop_at_once(step) {
            return Mode::Holding;
        }
        Mode::Braking(self.acceptor.braking())
    }

    /// The screw of the last demands, of a robot that moves together with others.
    fn learn_screw(&mut self, step: f64) -> Option<Screw> {
        self.together?;
        if self.screw.is_none() {
            self.screw = guarded(|| self.acceptor.screw(step)).ok();
        }
        self.screw
    }
}
