//! What a cell is made of, in plain numbers: for its table, for a recording, for a dry run.

use core::time::Duration;

use crate::model::robot::{InterpolationSpace, JointKind};
use crate::model::sensor::VspMode;
use crate::model::shape::Shape;

/// A cell.
#[derive(Clone, Debug)]
pub struct Layout {
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
pub struct RobotLayout {
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
pub struct JointLayout {
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
pub struct SensorLayout {
    pub name: String,
    pub kind: &'static str,
    /// The robot that it belongs to.
    pub of: Option<String>,
    pub mode: VspMode,
    pub latency: Duration,
    /// What its readings' words say.
    pub reading: &'static Shape,
}
