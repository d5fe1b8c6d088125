//! What a cell is made of, in plain numbers: for its table, for a recording, for a dry run.
//!
//! In: set-ups. Out: names, kinds, periods, modes and limits, and how long each joint's stop takes.

use core::time::Duration;

use crate::interpolation::InterpolationSpace;
use crate::joints::JointVector;
use crate::robot::{JointKind, Robot};
use crate::shape::Shape;
use crate::stopping::{braking_time, detection_time};
use crate::vsp::VspMode;

use super::Cell;

/// A cell.
#[derive(Clone, Debug)]
pub(crate) struct Layout {
    pub step: Duration,
    /// The longest stop that it allows.
    pub stop_time: Duration,
    /// The longest time between the cause of a stop and the start of braking \[s\].
    pub detection: f64,
    /// Whether the MP has a program of its own.
    pub mp_program: bool,
    pub robots: Vec<RobotLayout>,
    pub sensors: Vec<SensorLayout>,
}

/// A robot of it.
#[derive(Clone, Debug)]
pub(crate) struct RobotLayout {
    pub name: String,
    pub kind: &'static str,
    pub servo: Duration,
    /// Whether its drives know where it is.
    pub homed: bool,
    /// Whether its ECP has a program of its own.
    pub ecp_program: bool,
    pub space: InterpolationSpace,
    pub joints: Vec<JointLayout>,
}

/// A joint of it [rad or m, s].
#[derive(Clone, Copy, Debug)]
pub(crate) struct JointLayout {
    pub kind: JointKind,
    pub lower: f64,
    pub upper: f64,
    pub velocity: f64,
    pub acceleration: f64,
    pub jerk: Option<f64>,
    pub following_error: f64,
    /// The longest time that it brakes for \[s\].
    pub braking: f64,
}

/// A sensor of it.
#[derive(Clone, Debug)]
pub(crate) struct SensorLayout {
    pub name: String,
    pub kind: &'static str,
    /// The robot that it belongs to.
    pub of: Option<String>,
    pub mode: VspMode,
    pub latency: Duration,
    /// What its readings' words say.
    #[cfg_attr(not(feature = "recording"), allow(dead_code, reason = "for recordings"))]
    pub reading: &'static Shape,
}

impl Cell {
    /// What the cell is made of. Nothing need be right with it.
    pub(crate) fn layout(&self) -> Layout {
        Layout {
            step: self.step,
            stop_time: self.stop_time,
            detection: detection_time(self.step),
            mp_program: self.program.is_some(),
            robots: self.robots.iter().map(|robot| robot.layout()).collect(),
            sensors: self.sensors.iter().map(|sensor| sensor.layout()).collect(),
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
