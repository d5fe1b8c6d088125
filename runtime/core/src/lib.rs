//! `mrroc` extends Rust by the two instructions that programming any number of robots with any sensors needs.
//!
//! **Wait** holds until an initial condition is met. **Move** generates the next state of any number of robots
//! from their states and the readings of any number of virtual sensors, step by step, until a terminal condition.
//! What changes from motion to motion is plugged in as a plain step function: a [`condition`](macro@condition) or a
//! [`generator`](macro@generator).
//!
//! ```
//! use mrroc::{Cell, Demand, RobotSetup, State, Step, Tick, generator};
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
//! let start = Six::new(0.0, -1.57, 0.16, -0.16, 4.71, 0.0);
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
//! # Ok::<(), mrroc::CellError>(())
//! ```
//!
//! A program sees its robots and sensors as typed lists: a motion for `(Rnt, Polycrank)` takes exactly the handles
//! `(&mut rnt, &mut polycrank)`. Which of the coordinator's order, the robots' states and the sensors' readings a step
//! function takes is its [`Class`] (section 6 of the paper), and decides what is exchanged in a step.
//!
//! ARCHITECTURE.md shows how a [`Cell`] of processes runs it; SAFETY.md says what happens when something is wrong.

// Where shared memory and system calls need it, in `link/` and `processes/`, each block says why it is sound.
#![deny(unsafe_code)]

// The macros write absolute paths, here as in a user's crate.
extern crate self as mrroc;

// The layers, from the bottom up; a test of the workspace reads the imports and lets none point upwards.
pub mod console;
mod model;
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
    pub use crate::generator::{Always, Demand, Step, Tick};
    pub use crate::payload::{Order, Payload};
    pub use crate::pose::Pose;
    pub use crate::program::{Ecp, Mp};
    pub use crate::robot::{Robot, State};
    pub use crate::sensor::{Reading, ReadingOrder, Sensor, VirtualSensor};
    pub use crate::{condition, generator};
}

/// Robots: models, limits, images, and the drives that move them.
pub mod robot {
    pub use crate::control::guard::RobotView;
    pub use crate::model::driver::{DriveFault, Driver, Homing, Measured, Regulators, Search};
    pub use crate::model::image::{RobotImage, RobotState};
    pub use crate::model::list::State;
    pub use crate::model::joints::{JointVector, MAX_JOINTS};
    pub use crate::model::robot::{CoupledLimit, InterpolationSpace, JointKind, Limits, NoInverse, Robot};
}

/// Virtual sensors: what they read, and how they are ordered.
pub mod sensor {
    pub use crate::model::image::{Sensor, SensorImage};
    pub use crate::model::list::Reading;
    pub use crate::model::plausible::Plausible;
    pub use crate::model::sensor::{EffectorState, ReadingOrder, VirtualSensor, VspMode};
}

/// Generators and conditions: what they demand, what they take, and for which robots and sensors.
pub mod generator {
    pub use crate::control::transparent::Transparent;
    pub use crate::model::class::{Class, Level, Uses};
    pub use crate::model::demand::Demand;
    pub use crate::model::generator::{Condition, Generator};
    pub use crate::model::list::{
        AnyRobots, Language, Motion, RobotHandle, RobotList, Robots, RobotsEach, RobotsOf, SensorHandle,
        SensorList, SensorsEach, SensorsOf,
    };
    pub use crate::model::step::{Always, Step, Tick};
}

/// What an MP orders, and how values become words of a message.
pub mod payload {
    pub use crate::model::payload::{Nudge, Order, Payload};
    pub use crate::model::shape::Shape;
    pub use crate::model::wire::{BadWords, WORDS, Wire, layout_hash};
}

/// Poses, their representations, and wrenches.
pub mod pose {
    pub use crate::model::pose::{AngleAxis, Pose, Zyz};
    pub use crate::model::wrench::Wrench;
}

/// Faults: what went wrong, in which process, and what it means.
pub mod fault {
    pub use crate::model::fault::{Excess, Fault, FaultClass, FaultKind, FaultWords, ProcessId, Role};
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
}

pub use nalgebra;

// COMPAT
pub use cell::AfterFault;
pub use cell::Cell;
pub use cell::CellError;
pub use cell::RobotSetup;
pub use cell::RunReport;
pub use cell::SensorSetup;
pub use fault::BadName;
pub use fault::Excess;
pub use fault::Fault;
pub use fault::FaultClass;
pub use fault::FaultKind;
pub use fault::MAX_NAME;
pub use fault::Name;
pub use fault::ProcessId;
pub use fault::Role;
pub use generator::Always;
pub use generator::AnyRobots;
pub use generator::Class;
pub use generator::Condition;
pub use generator::Demand;
pub use generator::Generator;
pub use generator::Language;
pub use generator::Level;
pub use generator::Motion;
pub use generator::RobotHandle;
pub use generator::RobotList;
pub use generator::Robots;
pub use generator::RobotsEach;
pub use generator::RobotsOf;
pub use generator::SensorHandle;
pub use generator::SensorList;
pub use generator::SensorsEach;
pub use generator::SensorsOf;
pub use generator::Step;
pub use generator::Tick;
pub use generator::Transparent;
pub use generator::Uses;
pub use link::Clock;
pub use link::Nanos;
pub use link::Stuck;
pub use observe::NotRecorded;
pub use observe::Observation;
pub use observe::Recording;
pub use observe::ServoRecord;
pub use observe::Shown;
pub use operator::BadSpeed;
pub use operator::Latch;
pub use operator::LatchRefusal;
pub use operator::Operator;
pub use payload::BadWords;
pub use payload::Nudge;
pub use payload::Order;
pub use payload::Payload;
pub use payload::Shape;
pub use payload::WORDS;
pub use payload::Wire;
pub use pose::AngleAxis;
pub use pose::Pose;
pub use pose::Wrench;
pub use pose::Zyz;
pub use program::Ecp;
pub use program::Mp;
pub use robot::CoupledLimit;
pub use robot::DriveFault;
pub use robot::Driver;
pub use robot::Homing;
pub use robot::InterpolationSpace;
pub use robot::JointKind;
pub use robot::JointVector;
pub use robot::Limits;
pub use robot::MAX_JOINTS;
pub use robot::Measured;
pub use robot::NoInverse;
pub use robot::Regulators;
pub use robot::Robot;
pub use robot::RobotImage;
pub use robot::RobotState;
pub use robot::RobotView;
pub use robot::Search;
pub use robot::State;
pub use sensor::EffectorState;
pub use sensor::Plausible;
pub use sensor::Reading;
pub use sensor::ReadingOrder;
pub use sensor::Sensor;
pub use sensor::SensorImage;
pub use sensor::VirtualSensor;
pub use sensor::VspMode;
// END

pub use mrroc_macros::{Payload, condition, generator};

#[cfg(test)]
mod slide;

#[doc(hidden)]
#[path = "private.rs"]
pub mod __private1;
