//! Robots for `mrroc`: kinematics, limits, transmissions and simulated plants.
//!
//! One robot is one file, with a sketch of its frames, its limits, the constants of its transmission and of its drives,
//! and where each figure comes from: public facts of MRROC++, or marked "assumed".
//!
//! | robot | joints | inverse kinematics |
//! |---|---|---|
//! | [`Irp6`] | 6 | closed form, 8 solutions |
//! | [`Irp6FiveDof`] | 5 | closed form, 4 solutions; the tool's axis stays in the arm's plane |
//! | [`Irp6Track`] | 1 + 6 | closed form; the track by rule, or given |
//! | [`Rnt`], a stand-in | 6, two of them linear actuators | closed form through three closed loops |
//! | [`Polycrank`] | 7, endless | closed form, 8 families; the stretch of the seed kept, or given |
//! | [`Gripper`], [`Conveyor`] | 1 | one solution |
//! | [`Serial`], read from a URDF | 1 to 8 | closed form for ortho-parallel arms with a spherical wrist, else iteration |
//!
//! [`mrroc::Robot`] is what the runtime needs. [`Kinematics`] adds Jacobians, all solutions, goals within limits,
//! manipulability and the distance to singularities; [`Driven`] says how motors move the joints. What a simulation adds is
//! layered on top and knows nothing of kinematics:
//!
//! ```text
//! demanded q -> Driven -> Regulator (2 ms, per motor) -> Plant (motor and load) -> encoder
//!   measured q <------------------- Driven <-------------------------------------'
//! ```
//!
//! [`Simulated`] ties them together as a `mrroc::Driver`. [`conformance`] holds what every robot must keep, as tests for
//! robots of this crate and of others.
//!
//! ```
//! use mrroc::{Driver, Robot};
//! use mrroc_robots::{Kinematics, Polycrank, Seven, Simulated};
//!
//! let robot = Polycrank::new();
//! let q = Seven::from([0.3, 1.2, -0.4, 0.5, 1.1, -0.3, 0.2]);
//! let pose = robot.forward(&q);
//! let mut families = 0;
//! robot.solutions(&pose, &q, &mut |_| families += 1)?;
//! assert_eq!(families, 8);
//! let mut arm = Simulated::new(robot, &q);
//! arm.tick(&q)?;
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod clearance;
pub mod conformance;
mod conveyor;
mod drives;
pub mod grasp;
mod gripper;
mod homing;
mod irp6;
mod irp6_five;
mod irp6_track;
mod kinds;
mod kinematics;
mod opw;
mod plant;
mod polycrank;
mod regulator;
mod rnt;
mod simulated;
mod sines;
mod singular;
mod transmission;
mod urdf;
mod wrist;

pub use conveyor::Conveyor;
pub use drives::{Driven, MotorData, MotorLimits, Overload, Shafts};
pub use gripper::{Gripper, One};
pub use homing::Unhomed;
pub use irp6::{Irp6, Six};
pub use irp6_five::{Five, Irp6FiveDof};
pub use irp6_track::{Irp6Track, Seven};
pub use kinds::simulated;
pub use kinematics::{Jacobian, Kinematics};
pub use plant::{Encoder, Plant};
pub use polycrank::Polycrank;
pub use regulator::{Gains, Regulator, RegulatorSet};
pub use rnt::Rnt;
pub use simulated::{Shaft, Simulated, SimulatedIrp6};
pub use transmission::{Linear, LinkState, Screw, Transmission};
pub use urdf::{Serial, SerialBuilder, SerialOutline, UrdfError};
