//! Messages of ROS 2, as they are sent: the fields in this order, in CDR.
//!
//! Names and fields are those of `common_interfaces`, `geometry2` and `rcl_interfaces` of Jazzy.

use mrroc_core::pose::Pose;
use ros2_client::Message;
use serde::{Deserialize, Serialize};

/// A message that has a topic: its type is known by its package and its name.
pub trait RosType: Serialize {
    const PACKAGE: &'static str;
    const NAME: &'static str;
}

/// Says of which type messages are.
macro_rules! ros_types {
    ($($message:ty: $package:literal, $name:literal;)*) => {
        $(impl RosType for $message {
            const PACKAGE: &'static str = $package;
            const NAME: &'static str = $name;
        })*
    };
}

ros_types! {
    Text: "std_msgs", "String";
    Flag: "std_msgs", "Bool";
    Number: "std_msgs", "Float64";
    Numbers: "std_msgs", "Float64MultiArray";
    JointState: "sensor_msgs", "JointState";
    WrenchStamped: "geometry_msgs", "WrenchStamped";
    Transforms: "tf2_msgs", "TFMessage";
    DiagnosticArray: "diagnostic_msgs", "DiagnosticArray";
}

/// `builtin_interfaces/Time`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct Stamp {
    /// Seconds since 1970.
    pub sec: i32,
    /// And nanoseconds, below 1e9.
    pub nanosec: u32,
}

impl Stamp {
    /// Of a time since 1970 \[ns\].
    pub fn of(nanos: u64) -> Stamp {
        // The messages of ROS 2 end in 2038.
        let sec = i32::try_from(nanos / 1_000_000_000).unwrap_or(i32::MAX);
        Stamp { sec, nanosec: (nanos % 1_000_000_000) as u32 }
    }
}

/// `std_msgs/Header`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Header {
    /// When it was so.
    pub stamp: Stamp,
    /// In which frame it is told.
    pub frame_id: String,
}

/// `std_msgs/String`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Text {
    /// The text.
    pub data: String,
}

/// `std_msgs/Bool`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Flag {
    /// Whether it is on.
    pub data: bool,
}

/// `std_msgs/Float64`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Number {
    /// The number.
    pub data: f64,
}

/// `std_msgs/Float64MultiArray`, with its `MultiArrayLayout`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Numbers {
    pub dim: Vec<Dimension>,
    /// Where the data begin in `data`.
    pub data_offset: u32,
    pub data: Vec<f64>,
}

/// `std_msgs/MultiArrayDimension`.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Dimension {
    pub label: String,
    pub size: u32,
    /// Numbers in this dimension and those after it.
    pub stride: u32,
}

/// `sensor_msgs/JointState`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct JointState {
    /// When.
    pub header: Header,
    /// Names of the joints.
    pub name: Vec<String>,
    /// [rad or m].
    pub position: Vec<f64>,
    /// [rad/s or m/s].
    pub velocity: Vec<f64>,
    /// Empty: a cell does not know it.
    pub effort: Vec<f64>,
}

impl JointState {
    /// Of joints that have these names: their positions and velocities.
    pub fn of(stamp: Stamp, names: &[String], [position, velocity]: [&[f64]; 2]) -> JointState {
        JointState {
            header: Header { stamp, frame_id: String::new() },
            name: names.to_vec(),
            position: position.to_vec(),
            velocity: velocity.to_vec(),
            effort: Vec::new(),
        }
    }
}

/// `geometry_msgs/Vector3`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Vector {
    pub x: f64,
    pub y: f64,
    pub z: f64,
}

/// `geometry_msgs/Quaternion`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Turn {
    pub x: f64,
    pub y: f64,
    pub z: f64,
    pub w: f64,
}

/// `geometry_msgs/WrenchStamped`, with its `Wrench`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct WrenchStamped {
    /// When, and the frame at whose origin it acts and in whose axes it is written.
    pub header: Header,
    /// \[N\].
    pub force: Vector,
    /// [N m].
    pub torque: Vector,
}

/// `geometry_msgs/TransformStamped`, with its `Transform`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct TransformStamped {
    /// When, and the frame of the parent.
    pub header: Header,
    /// The frame that is placed.
    pub child_frame_id: String,
    /// Its origin in the parent \[m\].
    pub translation: Vector,
    /// Its attitude in the parent.
    pub rotation: Turn,
}

impl TransformStamped {
    /// Of a frame that has this pose in its parent.
    pub fn of(stamp: Stamp, parent: &str, child: &str, pose: &Pose) -> TransformStamped {
        let (p, q) = (pose.translation.vector, pose.rotation.coords);
        TransformStamped {
            header: Header { stamp, frame_id: parent.to_owned() },
            child_frame_id: child.to_owned(),
            translation: Vector { x: p.x, y: p.y, z: p.z },
            rotation: Turn { x: q.x, y: q.y, z: q.z, w: q.w },
        }
    }
}

/// `tf2_msgs/TFMessage`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Transforms {
    pub transforms: Vec<TransformStamped>,
}

/// `diagnostic_msgs/DiagnosticArray`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct DiagnosticArray {
    pub header: Header,
    pub status: Vec<DiagnosticStatus>,
}

/// `diagnostic_msgs/DiagnosticStatus`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct DiagnosticStatus {
    /// [`OK`], [`WARN`], [`ERROR`].
    pub level: u8,
    pub name: String,
    pub message: String,
    pub hardware_id: String,
    pub values: Vec<KeyValue>,
}

/// Levels of diagnostics.
pub const OK: u8 = 0;
pub const WARN: u8 = 1;
pub const ERROR: u8 = 2;

/// `diagnostic_msgs/KeyValue`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct KeyValue {
    pub key: String,
    pub value: String,
}

/// The request of `std_srvs/Trigger`: one byte, since a structure of nothing is not allowed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct TriggerRequest {
    nothing: u8,
}

impl Message for TriggerRequest {}

/// The response of `std_srvs/Trigger`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct TriggerResponse {
    pub success: bool,
    pub message: String,
}

impl Message for TriggerResponse {}
