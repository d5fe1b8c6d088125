//! Messages of `trajectory_msgs` and of the action `control_msgs/FollowJointTrajectory`, of Jazzy.

use ros2_client::Message;
use serde::{Deserialize, Serialize};

use crate::messages::{Header, Turn, Vector};

/// `builtin_interfaces/Duration`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Duration {
    pub sec: i32,
    pub nanosec: u32,
}

impl Duration {
    /// In seconds.
    pub fn seconds(self) -> f64 {
        f64::from(self.sec) + 1e-9 * f64::from(self.nanosec)
    }

    /// In nanoseconds.
    pub fn nanos(self) -> i64 {
        i64::from(self.sec) * 1_000_000_000 + i64::from(self.nanosec)
    }

    /// Of nanoseconds; `None`: so long a time cannot be told.
    pub fn of(nanos: i64) -> Option<Duration> {
        let sec = i32::try_from(nanos.div_euclid(1_000_000_000)).ok()?;
        Some(Duration { sec, nanosec: nanos.rem_euclid(1_000_000_000) as u32 })
    }
}

/// `trajectory_msgs/JointTrajectoryPoint`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Point {
    pub positions: Vec<f64>,
    pub velocities: Vec<f64>,
    pub accelerations: Vec<f64>,
    pub effort: Vec<f64>,
    pub time_from_start: Duration,
}

impl Point {
    /// How many numbers it has.
    pub fn numbers(&self) -> usize {
        1 + self.positions.len() + self.velocities.len() + self.accelerations.len()
    }
}

/// `trajectory_msgs/JointTrajectory`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Trajectory {
    pub header: Header,
    pub joint_names: Vec<String>,
    pub points: Vec<Point>,
}

/// `geometry_msgs/Transform`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Transform {
    translation: Vector,
    rotation: Turn,
}

/// `geometry_msgs/Twist`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Twist {
    linear: Vector,
    angular: Vector,
}

/// `trajectory_msgs/MultiDOFJointTrajectoryPoint`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct MultiPoint {
    transforms: Vec<Transform>,
    velocities: Vec<Twist>,
    accelerations: Vec<Twist>,
    time_from_start: Duration,
}

/// `trajectory_msgs/MultiDOFJointTrajectory`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct MultiTrajectory {
    header: Header,
    pub joint_names: Vec<String>,
    points: Vec<MultiPoint>,
}

/// `control_msgs/JointTolerance`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Tolerance {
    pub name: String,
    pub position: f64,
    pub velocity: f64,
    pub acceleration: f64,
}

/// `control_msgs/JointComponentTolerance`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ComponentTolerance {
    joint_name: String,
    component: u16,
    position: f64,
    velocity: f64,
    acceleration: f64,
}

/// The goal of `control_msgs/FollowJointTrajectory`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Request {
    pub trajectory: Trajectory,
    pub multi_dof_trajectory: MultiTrajectory,
    pub path_tolerance: Vec<Tolerance>,
    pub component_path_tolerance: Vec<ComponentTolerance>,
    pub goal_tolerance: Vec<Tolerance>,
    pub component_goal_tolerance: Vec<ComponentTolerance>,
    pub goal_time_tolerance: Duration,
}

impl Message for Request {}

/// Its error codes.
pub const SUCCESSFUL: i32 = 0;
pub const INVALID_GOAL: i32 = -1;
pub const INVALID_JOINTS: i32 = -2;
pub const OLD_HEADER_TIMESTAMP: i32 = -3;
pub const PATH_TOLERANCE_VIOLATED: i32 = -4;
pub const GOAL_TOLERANCE_VIOLATED: i32 = -5;

/// Its result.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Outcome {
    pub error_code: i32,
    pub error_string: String,
    /// Whether the robots are not where the trajectory begins. No part of the message.
    #[serde(skip)]
    pub is_elsewhere: bool,
}

impl Message for Outcome {}

/// Its feedback.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Feedback {
    pub header: Header,
    pub joint_names: Vec<String>,
    pub desired: Point,
    pub actual: Point,
    pub error: Point,
    pub multi_dof_joint_names: Vec<String>,
    pub multi_dof_desired: MultiPoint,
    pub multi_dof_actual: MultiPoint,
    pub multi_dof_error: MultiPoint,
}

impl Message for Feedback {}
