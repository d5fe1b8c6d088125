//! What the demands of a motion are counted from: the tool in force, and where the motion began.
//!
//! In: the first demand of a motion, tools. Out: the flange's pose at the start, from which displacements count.

use crate::model::pose::Pose;
use crate::model::robot::Robot;

/// The motion that is under way, or the last one.
#[derive(Clone, Copy)]
pub(super) struct Motion<J> {
    /// The tool in force, `X_FE`.
    pub tool: Pose,
    /// Joint positions at the start of the motion [rad or m].
    origin: J,
    /// The flange's pose there, once a displacement has asked for it.
    start: Option<Pose>,
    /// Whether its first demand is still to be accepted.
    pub starting: bool,
}

impl<J: Copy> Motion<J> {
    /// No motion has begun: the robot is at `position`.
    pub const fn none(tool: Pose, position: J) -> Self {
        Motion { tool, origin: position, start: None, starting: false }
    }

    /// One begins at `position`, with the tool that is in force.
    pub fn begin(&mut self, position: J) {
        self.origin = position;
        self.start = None;
        self.starting = true;
    }

    /// Pose of the flange at its start, `X_WF`.
    pub fn start<R: Robot<Joints = J>>(&mut self, robot: &R) -> Pose {
        *self.start.get_or_insert_with(|| robot.forward(&self.origin))
    }
}
