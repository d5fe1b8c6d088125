//! Typed lists: which robots and which sensors a step function is for.
//!
//! `(Rnt, Polycrank)` and `[Irp6; 3]` are lists of an MP; an ECP's list is its one robot, `Rnt`. The program
//! passes handles in the same form, `(&mut rnt, &mut polycrank)`; another robot, order or number does not
//! compile.

mod images;
mod robots;
mod sensors;
mod shared;
mod tuples;

pub use images::{Reading, State};
pub use robots::{AnyRobots, Language, Motion, Owner, RobotHandle, RobotList, Robots, RobotsEach, RobotsOf};
#[doc(hidden)]
pub use robots::{ListOf, PayloadType, Spoken};
pub use sensors::{SensorHandle, SensorList, SensorsEach, SensorsOf};
pub use shared::{JoinedRobots, SharedRobots, SharedSensors};
