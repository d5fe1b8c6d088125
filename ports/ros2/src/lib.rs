//! A cell among the nodes of ROS 2: what its robots do and its sensors read as topics, topics of others as its sensors, its operator's console as services, trajectories as an action.
//!
//! In: what a cell shows at a port in each step, and requests of other nodes. Out: messages over DDS, and requests to the cell's console server. The
//! bridge is a process of its own and one more console: no process that moves robots speaks DDS or waits for one that does, and a cell whose
//! bridge is killed goes on.
//!
//! A project has it as a second program, `src/bin/ros2.rs`, so that the cell itself is built without it:
//!
//! ```no_run
//! # use mrroc_core::cell::{Cell, CellError};
//! # use mrroc_launch::cell_file::CellFile;
//! # fn cell(file: &CellFile) -> Result<Cell, CellError> { file.cell(&mrroc_robots::simulated()) }
//! fn main() -> std::process::ExitCode {
//!     // The function that makes the cell of `cell.toml`; it says `.shown_to(Subscribers::at("welding"))`.
//!     mrroc_ros2::run("welding", cell)
//! }
//! ```
//!
//! The cell runs as processes in one terminal, the bridge in another: `cargo run --features ros2 --bin ros2`. Either may be started first.
//!
//! | topic, service or parameter | type | what |
//! |---|---|---|
//! | `/ROBOT/joint_states` | `sensor_msgs/JointState` | measured joint positions and velocities of every step, named as in the URDF |
//! | `/ROBOT/demanded_joint_states` | `sensor_msgs/JointState` | the same as demanded |
//! | `/joint_states` | `sensor_msgs/JointState` | the measured ones of all robots, one robot in a message, 50 times a second, with the robots' names where joints of several robots have one name |
//! | `/ROBOT/robot_description` | `std_msgs/String` | the URDF that the robot writes of itself; kept for who comes later |
//! | `/ROBOT/inputs/NAME`, `/ROBOT/outputs/NAME` | `std_msgs/Bool` or `Float64` | the robot's named signals, when they change; kept for who comes later |
//! | `/sensors/NAME/FIELD` | `std_msgs/Float64`, `Bool`, `String` or `Float64MultiArray` | each reading that the MP or an ECP collects, a topic for each number and each list of numbers |
//! | `/sensors/NAME` | `geometry_msgs/WrenchStamped` | readings that are wrenches, in the frame `ROBOT/tool` of the sensor's robot |
//! | `/tf`, `/tf_static` | `tf2_msgs/TFMessage` | `world`, the frames of the cell, and the links of each URDF as `ROBOT/LINK`, whose link `world` is the world or the flange of the robot that carries it; `/tf` 50 times a second |
//! | `/NODE/state` | `std_msgs/String` | what the cell does: `idle`, `running`, `suspended` ..; kept for who comes later |
//! | `/NODE/instruction` | `std_msgs/String` | the coordinator's present instruction, and the generator or condition of that: `move FollowTwist`, `wait Heard`; looked at 20 times a second; `nothing` between instructions, and where no cell answers |
//! | `/diagnostics` | `diagnostic_msgs/DiagnosticArray` | once a second, and when the state or the fault changes: the cell and each of its processes |
//! | with `--buttons`: `/NODE/suspend`, `resume`, `abort`, `stop`, `acknowledge`, `reset` | `std_srvs/Trigger` | the buttons of the operator's console |
//! | with `--goals`: `/ROBOT/follow_joint_trajectory`, `/NODE/follow_joint_trajectory` | `control_msgs/FollowJointTrajectory` | trajectories of one robot, or of several as one goal, for a program that takes [`TrajectoryGoals`](mrroc_external::TrajectoryGoals) |
//! | topics of `[sensors.NAME.external.topic]` in `cell.toml` | any | subscribed to: their messages are readings of the cell's sensors |
//! | with `--buttons`: `speed` of `/NODE` | parameter, double | the speed as a share of the planned one, 0 to 1 |
//!
//! With `--export-bag` a recording becomes a bag of rosbag2 with the same messages, and with `--from-bag` robots follow the trajectories of a bag: `bags`.
//! With `--sensors-from-bag` topics that are sensors are those of a bag. `--check` tells all that is wrong before DDS begins: `checks`.
//!
//! `NODE` is `cell` unless `--node` says otherwise. Stamps are the cell's time, beginning at the wall clock when the bridge saw its first step. Everything is
//! reliable, unless `[topics."/NAME"]` in `cell.toml` says otherwise. **DDS has no access control, and its sockets hear all networks of the machine**, whatever address `--address` tells others: whoever reaches the machine
//! sees the cell, with `--buttons` presses its buttons, with `--goals` moves its robots, and publishes to topics that are sensors. A firewall is what keeps others out.
//!
//! Tested with rclpy of Jazzy over Fast DDS, and topics with Cyclone DDS. Services and parameters are in the form of Fast DDS alone. Not there yet:
//! robots and sensors of lower cells.

#![forbid(unsafe_code)]
#![cfg(target_os = "linux")]
#![allow(clippy::disallowed_methods, reason = "a console is no part of control")]

mod bags;
mod buttons;
mod checks;
mod clock;
mod definitions;
mod description;
mod diagnostics;
mod messages;
mod moveit;
mod node;
mod options;
mod outlet;
mod readings;
mod run;
mod show;
mod signals;
mod topics;
mod trajectories;

pub use run::run;
