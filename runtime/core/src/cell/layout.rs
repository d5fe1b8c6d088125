//! What a cell is made of, in plain numbers: for its table, for a recording, for a dry run.
//!
//! In: set-ups. Out: names, kinds, periods, modes and limits, and how long each joint's stop takes.

use crate::model::joints::JointVector;
use crate::model::robot::Robot;
use crate::observe::layout::{JointLayout, Layout};
use crate::safety::stopping::braking_time;

use super::Cell;

impl Cell {
    /// What the cell is made of. Nothing need be right with it.
    pub fn layout(&self) -> Layout {
        let robots = self.parts.robots.iter().map(|robot| robot.layout(self.timing.stop_time));
        let sensors = self.parts.sensors.iter().map(|sensor| sensor.layout(self.timing.step));
        Layout {
            step: self.timing.step,
            stop_time: self.timing.stop_time,
            path_stop: self.path_stop_time(),
            protective_stop: self.timing.step * u32::try_from(self.path_stop_steps()).unwrap_or(u32::MAX),
            detection: self.parts.noticing_time(&self.timing),
            mp_program: self.coordination.program.is_some(),
            cells: self.lower_cells().collect(),
            robots: robots.chain(self.lower_robots()).collect(),
            sensors: sensors.chain(self.lower_sensors()).collect(),
            frames: self.parts.named.frames.clone(),
            tools: self.parts.named.tools.clone(),
            bodies: self.watching.bodies.iter().map(|(layout, _)| layout.clone()).collect(),
            obstacles: self.watching.obstacles.clone(),
        }
    }
}

/// The joints of a robot.
pub(super) fn joints<R: Robot>(robot: &R, following_error: &R::Joints) -> Vec<JointLayout> {
    let limits = robot.limits();
    let joint = |i: usize| JointLayout {
        kind: robot.joint(i),
        lower: limits.lower[i],
        upper: limits.upper[i],
        velocity: limits.velocity[i],
        acceleration: limits.acceleration[i],
        jerk: limits.jerk.map(|jerk| jerk[i]),
        following_error: following_error[i],
        braking: braking_time(limits, i),
    };
    (0..R::Joints::LEN).map(joint).collect()
}
