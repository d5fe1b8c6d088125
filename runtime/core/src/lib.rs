//! `mrroc` extends Rust by the two instructions that programming any number of robots with any sensors needs.
//!
//! **Wait** holds until an initial condition is met. **Move** generates the next state of any number of robots
//! from their states and the readings of any number of virtual sensors, step by step, until a terminal condition.
//! What changes from motion to motion is plugged in as a plain step function: a [`condition`](macro@condition) or a
//! [`generator`](macro@generator).
//!
//! ```
//! use mrroc::prelude::*;
//! use mrroc_robots::{Irp6, SimulatedIrp6, Six};
//!
//! /// Turns the column by half a radian in two seconds, smoothly.
//! struct Turn { from: Six, t: f64 }
//!
//! #[generator(mp, first = learn)]
//! fn turn(c: &mut Turn, t: Tick) -> Step<(Irp6,)> {
//!     if c.t >= 2.0 {
//!         return Step::Done;
//!     }
//!     c.t += t.dt;
//!     let u = (c.t / 2.0).min(1.0);
//!     let mut q = c.from;
//!     q[0] += 0.5 * u * u * (3.0 - 2.0 * u);
//!     Step::Next((Demand::joints(q),))
//! }
//!
//! /// Only the first step needs to know where the arm is.
//! fn learn(c: &mut Turn, e: &State<(Irp6,)>, t: Tick) -> Step<(Irp6,)> {
//!     c.from = e.0.demanded().joints;
//!     turn(c, t)
//! }
//!
//! let start = Irp6::READY;
//! let arm = SimulatedIrp6::new(Irp6::nominal(), &start);
//! let report = Cell::new(std::time::Duration::from_millis(2))
//!     .robot(RobotSetup::new("irp6", Irp6::nominal(), arm))
//!     .program(move |mp| {
//!         let mut irp6 = mp.robot::<Irp6>("irp6")?;
//!         mp.move_robots((&mut irp6,), (), Turn { from: start, t: 0.0 })?;
//!         assert!((irp6.measured().joints[0] - 0.5).abs() < 1e-3);
//!         Ok(())
//!     })
//!     .run()?;
//! assert!(report.time.as_secs_f64() > 2.0);
//! # Ok::<(), mrroc::cell::CellError>(())
//! ```
//!
//! A program sees its robots and sensors as typed lists: a motion for `(Rnt, Polycrank)` takes exactly the handles
//! `(&mut rnt, &mut polycrank)`. Which of the coordinator's order, the robots' states and the sensors' readings a step
//! function takes is its [`Class`](generator::Class) (section 6 of the paper), and decides what is exchanged in a step.
//!
//! ARCHITECTURE.md shows how a [`Cell`](cell::Cell) of processes runs it; SAFETY.md says what happens when something is wrong.

// Where shared memory and system calls need it, in `link/` and `processes/`, each block says why it is sound.
#![deny(unsafe_code)]

// The macros write absolute paths, here as in a user's crate.
extern crate self as mrroc;

// The layers, from the bottom up; a test of the workspace reads the imports and lets none point upwards.
pub mod console;
pub mod files;
mod model;
pub mod random;
mod safety;
pub mod suggestion;

pub mod operator;

pub mod link;

pub mod observe;

mod control;

pub mod cell;

/// What a program names most: `use mrroc::prelude::*;`.
pub mod prelude {
    pub use crate::cell::{Cell, CellError, RobotSetup, SensorSetup};
    pub use crate::fault::Fault;
    pub use crate::generator::{Always, Demand, Each, Step, Tick};
    pub use crate::payload::{Order, Payload};
    pub use crate::pose::Pose;
    pub use crate::program::{Ecp, Mp};
    pub use crate::robot::{Robot, State};
    pub use crate::sensor::{Reading, ReadingOrder, Sensor, VirtualSensor};
    pub use crate::{condition, generator};
}

/// Robots: models, limits, images, and the drives that move them.
pub mod robot {
    pub use crate::control::connecting::Connecting;
    pub use crate::control::guard::RobotView;
    pub use crate::control::ideal::IdealDrives;
    pub use crate::model::drive_fault::DriveFault;
    pub use crate::model::driver::{
        Channels, Driver, Homing, Measured, RECOVERY, Recovery, Regulators, Search, SimulatedDrives, Stepped,
        WhenLost,
    };
    pub use crate::model::image::{RobotImage, RobotState};
    pub use crate::model::joints::{JointVector, MAX_JOINTS};
    pub use crate::model::list::State;
    pub use crate::model::load::{Load, Tool};
    pub use crate::model::pace::{Pace, Pulse};
    pub use crate::model::robot::{
        CoupledLimit, InterpolationSpace, JointKind, Limits, LinkMesh, NoInverse, POSITION_ROUND_OFF, Robot,
    };
    pub use crate::model::robot_stop::{ClearedBy, RobotStop, StopCause};
    pub use crate::model::signals::{
        ANALOG, Channel, DIGITAL, Input, Level, Output, Outputs, Signal, Signals, Value, Values,
    };
    pub use crate::model::stepped::{Begin, Simulated, Simulator, SteppedDrives};
    pub use crate::safety::stopping::detection_time;
}

/// Virtual sensors: what they read, and how they are ordered.
pub mod sensor {
    pub use crate::model::frames::{Content, Frame, FrameSink, Frames};
    pub use crate::model::image::{Sensor, SensorImage};
    pub use crate::model::list::Reading;
    pub use crate::model::plausible::Plausible;
    pub use crate::model::sensor::{EffectorState, ReadingOrder, Taken, VirtualSensor, VspMode};
}

/// Generators and conditions: what they demand, what they take, and for which robots and sensors.
pub mod generator {
    pub use crate::control::transparent::Transparent;
    pub use crate::model::class::{Class, Level, Uses};
    pub use crate::model::demand::Demand;
    pub use crate::model::each::{Each, Joined, Repeated};
    pub use crate::model::generator::{Condition, Generator};
    pub use crate::model::list::{
        AnyRobots, JoinedRobots, Language, Motion, RobotHandle, RobotList, Robots, RobotsEach, RobotsOf,
        SensorHandle, SensorList, SensorsEach, SensorsOf, SharedRobots, SharedSensors,
    };
    pub use crate::model::moved::RobotsMovedBy;
    pub use crate::model::step::{Always, Step, Tick};
    pub use crate::model::type_name::TypeName;
    pub use crate::safety::ramp::steepest;
}

/// What an MP orders, and how values become words of a message.
pub mod payload {
    pub use crate::model::payload::{Order, Payload, Trigger};
    pub use crate::model::shape::Shape;
    pub use crate::model::wire::{BadWords, WORDS, Wire, layout_hash};
    pub use mrroc_macros::Payload;
}

/// Poses, their representations, and wrenches.
pub mod pose {
    pub use crate::model::pose::{AngleAxis, Pose, Rpy, Zyz};
    pub use crate::model::wrench::Wrench;
}

/// Faults: what went wrong, in which process, and what it means.
pub mod fault {
    pub use crate::model::excess::Excess;
    pub use crate::model::fault::{BY_OPERATOR, Fault, FaultClass, FaultKind, FaultWords, ProcessId, Role};
    pub use crate::model::instruction::Instruction;
    pub use crate::model::name::{BadName, MAX_NAME, Name};
}

/// What a recording gives back in a replay, in place of drives, sensors and the operator.
pub mod replay {
    pub use crate::control::replay::*;
}

/// What a program is given: the MP's side and an ECP's.
pub mod program {
    pub use crate::control::ecp::Ecp;
    pub use crate::control::mp::Mp;
    pub use crate::control::recorded::Recorded;
}

pub use nalgebra;

pub use mrroc_macros::{condition, generator};

// The examples of the macros: their own crate has no `mrroc` that these could use.
#[cfg(doctest)]
#[doc = include_str!("../../../macros/src/docs/generator.md")]
#[doc = include_str!("../../../macros/src/docs/condition.md")]
#[doc = include_str!("../../../macros/src/docs/payload.md")]
mod examples_of_macros {}

#[cfg(test)]
mod tests;

#[doc(hidden)]
#[path = "private.rs"]
pub mod __private1;
