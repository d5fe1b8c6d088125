//! Multi-robot research-oriented controller.

// The macros write absolute paths, here as in a user's crate.
extern crate self as mrroc;

mod braking;
mod cell;
mod class;
mod demand;
mod driver;
mod ecp;
mod edp;
mod fault;
mod feed;
mod generator;
mod image;
mod joints;
mod limits;
mod link;
mod list;
mod message;
mod mp;
mod name;
mod operator;
mod payload;
mod pose;
mod robot;
mod sensing;
mod step;
mod step_fn;
mod transparent;
mod vsp;
mod wire;

pub use cell::{Cell, CellError, RobotSetup, RunReport, SensorSetup};
pub use class::{Class, Level, Uses};
pub use demand::Demand;
pub use driver::{DriveFault, Driver, Measured};
pub use ecp::Ecp;
pub use edp::ServoRecord;
pub use fault::{Excess, Fault, FaultClass, FaultKind, ProcessId, Role};
pub use generator::{Condition, Generator};
pub use image::{Reading, RobotImage, RobotState, Sensor, SensorImage, State};
pub use joints::{JointVector, MAX_JOINTS};
pub use list::{
    AnyRobots, Language, Motion, RobotHandle, RobotList, Robots, RobotsOf, SensorHandle, SensorList,
    SensorsOf,
};
pub use mp::Mp;
pub use name::{BadName, MAX_NAME, Name};
pub use operator::{BadSpeed, Operator};
pub use payload::{Nudge, Order, Payload};
pub use pose::{AngleAxis, Pose, Zyz};
pub use robot::{CoupledLimit, JointKind, Limits, NoInverse, Robot};
pub use step::{Always, Step, Tick};
pub use transparent::Transparent;
pub use vsp::{EffectorState, ReadingOrder, VirtualSensor, VspMode};
pub use wire::{BadWords, WORDS, Wire};

pub use mrroc_macros::{Payload, condition, generator};

#[doc(hidden)]
#[path = "private.rs"]
pub mod __private1;
