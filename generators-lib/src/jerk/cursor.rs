//! A synchronised motion followed in increments of path time, which may change its target during the motion.

use mrroc::robot::JointVector;

use super::{JerkError, JointLimits, JointPoint, JointState, JointTarget, SynchronisedMove};

/// A walk along a [`SynchronisedMove`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MoveCursor<J> {
    motion: SynchronisedMove<J>,
    time: f64,
    ended: bool,
}

impl<J: JointVector> MoveCursor<J> {
    /// At the start of `motion`.
    #[must_use]
    pub fn new(motion: SynchronisedMove<J>) -> Self {
        MoveCursor { motion, time: 0.0, ended: false }
    }

    /// Advances by `dt` \[s\], >= 0. The exact end is emitted once, then `None`.
    pub fn advance(&mut self, dt: f64) -> Option<JointPoint<J>> {
        if self.ended {
            return None;
        }
        self.time += dt;
        // The sum of n increments may miss n * dt by rounding; that must not cost a step.
        if self.motion.duration() - self.time <= 1e-9 * dt {
            self.time = self.motion.duration();
            self.ended = true;
        }
        Some(self.here())
    }

    /// All axes now.
    #[must_use]
    pub fn here(&self) -> JointPoint<J> {
        self.motion.at(self.time)
    }

    /// The motion being walked.
    #[must_use]
    pub fn motion(&self) -> &SynchronisedMove<J> {
        &self.motion
    }

    /// Turns to another target from the state of this instant, in the shortest time, without a step in velocity or
    /// acceleration. To the target that it has already, it goes on as it is.
    ///
    /// # Errors
    /// A target that makes no plan; the cursor then stays on its motion.
    pub fn turn_to(&mut self, target: &JointTarget<J>, limits: &JointLimits<J>) -> Result<(), JerkError> {
        if *target != self.motion.target() {
            let state = JointState::from(self.here());
            *self = MoveCursor::new(SynchronisedMove::new(&state, target, limits)?);
        }
        Ok(())
    }
}
