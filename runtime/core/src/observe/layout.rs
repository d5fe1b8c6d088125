//! What a cell is made of, in plain numbers: for its table, for a recording, for a dry run.

use core::fmt;
use core::time::Duration;
use std::sync::Arc;

use nalgebra::Vector3;

use crate::model::joints::JointVector;
use crate::model::load::Tool;
use crate::model::name::is_in_lower_cell;
use crate::model::pose::Pose;
use crate::model::robot::{CoupledLimit, InterpolationSpace, JointKind, LinkMesh, Robot};
use crate::model::sensor::VspMode;
use crate::model::shape::Shape;
use crate::model::signals::Channel;
use crate::observe::solid::ObstacleLayout;

/// A cell.
#[derive(Clone, Debug)]
pub struct Layout {
    /// Length of a step.
    pub step: Duration,
    /// The longest stop that it allows a robot that says nothing else.
    pub stop_time: Duration,
    /// The longest time that a suspension or an abort takes on the path.
    pub path_stop: Duration,
    /// How long a protective stop stays on the path.
    pub protective_stop: Duration,
    /// The longest time between the cause of a stop and the start of braking \[s\].
    pub detection: f64,
    /// Whether the MP has a program of its own.
    pub mp_program: bool,
    /// Its lower cells and theirs, by their names in this one, with the length of their steps; their robots and sensors are among
    /// those below, `press.arm`.
    pub cells: Vec<(String, Duration)>,
    /// Its robots.
    pub robots: Vec<RobotLayout>,
    /// Its virtual sensors.
    pub sensors: Vec<SensorLayout>,
    /// The frames that it names, such as a table: their poses in the world, `X_WU` \[m\].
    pub frames: Vec<(String, Pose)>,
    /// The tools that it names.
    pub tools: Vec<(String, Tool)>,
    /// The bodies that its robots handle, as far as it [shows](crate::cell::Cell::shows_body) them.
    pub bodies: Vec<BodyLayout>,
    /// What stands in it, as far as it [shows](crate::cell::Cell::shows_obstacle) that.
    pub obstacles: Vec<ObstacleLayout>,
}

/// A body that the robots of a cell handle: a block about its frame.
#[derive(Clone, Debug)]
pub struct BodyLayout {
    /// Its name in the cell.
    pub name: String,
    /// Edges along x, y, z of its frame \[m\].
    pub edges: [f64; 3],
}

/// A robot of a cell.
#[derive(Clone, Debug)]
pub struct RobotLayout {
    /// Its name in the cell.
    pub name: String,
    /// Its kind's name.
    pub kind: &'static str,
    /// How often its drives take a position.
    pub servo: Duration,
    /// What its drives are.
    pub drives: HardwareLayout,
    /// Whether its drives know where it is.
    pub homed: bool,
    /// Whether its ECP has a program of its own.
    pub ecp_program: bool,
    /// Where its EDP interpolates between two demands.
    pub space: InterpolationSpace,
    /// The robot on whose flange it is mounted.
    pub mounted_on: Option<String>,
    /// The longest stop that it is allowed.
    pub stop_time: Duration,
    /// Limits that cannot be said joint by joint, in words: [`Robot::coupled_limits`].
    pub coupled_limits: Vec<String>,
    /// Its named inputs and outputs.
    pub signals: Vec<SignalLayout>,
    /// Its joints, from the base on.
    pub joints: Vec<JointLayout>,
    /// Where its links are.
    pub figure: Arc<dyn Figure>,
}

/// A named input or output of a robot.
#[derive(Clone, Debug, PartialEq)]
pub struct SignalLayout {
    /// Its name.
    pub name: String,
    /// Its channel.
    pub channel: Channel,
    /// Whether it is an output.
    pub is_output: bool,
    /// What an output does at a stop, and when its controller is told nothing any more.
    pub note: String,
}

/// A robot of any kind, for those who draw it or check its paths in a thread of their own: where its links are.
///
/// A robot that is mounted on another one stands in that robot's flange, any other one in the world.
pub trait Figure: Send + Sync {
    /// Visits the frames of the links at these joint positions [rad or m], as [`Robot::frames`]; none if they are too few.
    fn frames(&self, joints: &[f64], visit: &mut dyn FnMut(&Pose));

    /// Visits the links' capsules at these joint positions [rad or m], as [`Robot::capsules_of_links`]: ends and radius
    /// \[m\]; none if they are too few.
    fn capsules(&self, joints: &[f64], visit: &mut dyn FnMut([Vector3<f64>; 2], f64));

    /// The files of the links' visible shapes, as [`Robot::meshes`].
    fn meshes(&self) -> &[LinkMesh] {
        &[]
    }

    /// Checks limits that joints share, as [`Robot::check_coupled`], on a displacement [rad or m] in a time \[s\].
    ///
    /// # Errors
    /// The first [`CoupledLimit`] that it breaks.
    fn check_coupled(&self, _from: &[f64], _to: &[f64], _duration: f64) -> Result<(), CoupledLimit> {
        Ok(())
    }
}

impl fmt::Debug for dyn Figure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Figure")
    }
}

impl Layout {
    /// The same without the robots and sensors of its lower cells, which recordings have, and no program of others is shown.
    #[must_use]
    pub fn without_lower_cells(mut self) -> Layout {
        self.cells.clear();
        self.robots.retain(|robot| !is_in_lower_cell(&robot.name));
        self.sensors.retain(|sensor| !is_in_lower_cell(&sensor.name));
        self
    }
}

impl<R: Robot> Figure for R {
    fn frames(&self, joints: &[f64], visit: &mut dyn FnMut(&Pose)) {
        if joints.len() >= R::Joints::LEN {
            Robot::frames(self, &R::Joints::from_joints(|i| joints[i]), visit);
        }
    }

    fn capsules(&self, joints: &[f64], visit: &mut dyn FnMut([Vector3<f64>; 2], f64)) {
        if joints.len() >= R::Joints::LEN {
            self.capsules_of_links(&R::Joints::from_joints(|i| joints[i]), visit);
        }
    }

    fn meshes(&self) -> &[LinkMesh] {
        Robot::meshes(self)
    }

    fn check_coupled(&self, from: &[f64], to: &[f64], duration: f64) -> Result<(), CoupledLimit> {
        if from.len() < R::Joints::LEN || to.len() < R::Joints::LEN {
            return Ok(());
        }
        let [from, to] = [from, to].map(|joints| R::Joints::from_joints(|i| joints[i]));
        Robot::check_coupled(self, &from, &to, duration)
    }
}

/// What the drives of a robot, or what a sensor reads, are in the world: they say so themselves,
/// [`Driver::hardware`](crate::robot::Driver::hardware), [`VirtualSensor::hardware`](crate::sensor::VirtualSensor::hardware).
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum HardwareLayout {
    /// Nothing: they are simulated, or say nothing.
    Nothing,
    /// This hardware.
    Real(String),
    /// A simulator of others.
    Simulator(String),
    /// What is simulated in place of this hardware.
    StandIn(String),
}

impl HardwareLayout {
    /// Of what has this hardware, or is in the place of that.
    #[must_use]
    pub fn of(hardware: Option<String>, in_place_of: Option<&str>) -> Self {
        match (hardware, in_place_of) {
            (Some(hardware), _) => HardwareLayout::Real(hardware),
            (None, Some(hardware)) => HardwareLayout::StandIn(hardware.to_owned()),
            (None, None) => HardwareLayout::Nothing,
        }
    }
}

/// A joint of a robot: its limits, in radians or metres by its kind.
#[derive(Clone, Copy, Debug)]
pub struct JointLayout {
    /// How it moves.
    pub kind: JointKind,
    /// Lower position limit [rad or m].
    pub lower: f64,
    /// Upper position limit [rad or m].
    pub upper: f64,
    /// Largest speed [rad/s or m/s].
    pub velocity: f64,
    /// Largest acceleration [rad/s² or m/s²].
    pub acceleration: f64,
    /// Largest jerk [rad/s³ or m/s³]; `None`: not limited.
    pub jerk: Option<f64>,
    /// Largest difference between its demanded and its measured position [rad or m].
    pub following_error: f64,
    /// The longest time that it brakes for \[s\].
    pub braking: f64,
}

/// A virtual sensor of a cell.
#[derive(Clone, Debug)]
pub struct SensorLayout {
    /// Its name in the cell.
    pub name: String,
    /// Its kind's name.
    pub kind: &'static str,
    /// The robot that it belongs to.
    pub of: Option<String>,
    /// The robots whose ECPs may read it.
    pub readers: Vec<String>,
    /// How many steps one order for a reading is for.
    pub every: u32,
    /// The age at which a reading is too old to move by.
    pub stale_after: Duration,
    /// How it and its requesters keep step.
    pub mode: VspMode,
    /// Time that one aggregation takes, under the virtual clock.
    pub latency: Duration,
    /// What its readings' words say.
    pub reading: &'static Shape,
    /// The hash of their type: [`Wire::LAYOUT`](crate::payload::Wire::LAYOUT).
    pub reading_layout: u64,
    /// What it reads in the world.
    pub hardware: HardwareLayout,
}
