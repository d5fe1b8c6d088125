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

mod advice;
mod approach;
mod braking;
#[cfg_attr(
    not(all(feature = "processes", target_os = "linux")),
    allow(dead_code, reason = "consoles are processes")
)]
mod button;
mod cell;
mod cell_file;
mod class;
pub mod console;
mod demand;
mod driver;
mod ecp;
mod edp;
mod fault;
mod feed;
mod generator;
mod guard;
mod homing;
mod image;
mod interpolation;
mod joints;
mod latch;
mod launch;
mod limits;
mod link;
mod list;
mod message;
mod mp;
mod name;
mod operator;
mod overruns;
mod payload;
mod plant;
mod plausible;
mod pose;
#[cfg(all(feature = "processes", target_os = "linux"))]
mod processes;
mod realtime;
mod recording;
#[cfg_attr(not(feature = "recording"), allow(dead_code, reason = "for recordings"))]
mod replay;
mod robot;
mod sensing;
mod shape;
mod shown;
#[cfg(test)]
mod slide;
mod step;
mod step_fn;
mod stopping;
mod suggestion;
mod task_space;
pub mod testing;
mod together;
mod transparent;
#[cfg(all(feature = "view", target_os = "linux"))]
mod view;
mod vsp;
mod wire;
mod witness;
mod wrench;

pub use cell::{AfterFault, Cell, CellError, Observation, RobotSetup, RunReport, SensorSetup};
pub use cell_file::{CellFile, CellFileError, Kinds, RobotEntry};
pub use class::{Class, Level, Uses};
pub use demand::Demand;
pub use driver::{DriveFault, Driver, Homing, Measured, Regulators, Search};
pub use ecp::Ecp;
pub use edp::ServoRecord;
pub use fault::{Excess, Fault, FaultClass, FaultKind, ProcessId, Role};
pub use generator::{Condition, Generator};
pub use guard::RobotView;
pub use image::{Reading, RobotImage, RobotState, Sensor, SensorImage, State};
pub use interpolation::InterpolationSpace;
pub use joints::{JointVector, MAX_JOINTS};
pub use latch::{Latch, LatchRefusal};
pub use launch::{Clock, Launch, Ran, Recorder, launch};
pub use list::{
    AnyRobots, Language, Motion, RobotHandle, RobotList, Robots, RobotsEach, RobotsOf, SensorHandle,
    SensorList, SensorsEach, SensorsOf,
};
pub use mp::Mp;
pub use name::{BadName, MAX_NAME, Name};
pub use operator::{BadSpeed, Operator};
pub use payload::{Nudge, Order, Payload};
pub use plausible::Plausible;
pub use pose::{AngleAxis, Pose, Zyz};
#[cfg(feature = "recording")]
pub use recording::{CutOff, NotReplayable, ReplayError};
pub use recording::{NotRecorded, Recording};
#[cfg(feature = "recording")]
pub use replay::compare::{Compared, Difference};
pub use robot::{CoupledLimit, JointKind, Limits, NoInverse, Robot};
pub use shape::Shape;
pub use shown::Shown;
pub use step::{Always, Step, Tick};
pub use transparent::Transparent;
pub use vsp::{EffectorState, ReadingOrder, VirtualSensor, VspMode};
pub use wire::{BadWords, WORDS, Wire};
pub use wrench::Wrench;

pub use mrroc_macros::{Payload, condition, generator};

#[doc(hidden)]
#[path = "private.rs"]
pub mod __private1;
