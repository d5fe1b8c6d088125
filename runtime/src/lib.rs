//! Multi-robot research-oriented controller.

// The macros write absolute paths, here as in a user's crate.
extern crate self as mrroc;

mod class;
mod demand;
mod driver;
mod fault;
mod generator;
mod image;
mod joints;
mod list;
mod name;
mod payload;
mod pose;
mod robot;
mod step;
mod step_fn;
mod wire;

pub use class::{Class, Level, Uses};
pub use demand::Demand;
pub use driver::{DriveFault, Driver, Measured};
pub use fault::{Excess, Fault, FaultClass, FaultKind, ProcessId, Role};
pub use generator::{Condition, Generator};
pub use image::{Reading, RobotImage, RobotState, Sensor, SensorImage, State};
pub use joints::{JointVector, MAX_JOINTS};
pub use list::{
    AnyRobots, Language, Motion, RobotHandle, RobotList, Robots, RobotsOf, SensorHandle, SensorList,
    SensorsOf,
};
pub use name::{BadName, MAX_NAME, Name};
pub use payload::{Nudge, Order, Payload};
pub use pose::Pose;
pub use robot::{Limits, NoInverse, Robot};
pub use step::{Always, Step, Tick};
pub use wire::{BadWords, WORDS, Wire};

pub use mrroc_macros::{Payload, condition, generator};

#[doc(hidden)]
#[path = "private.rs"]
pub mod __private1;
