//! Robots for `mrroc`: kinematics, limits, transmissions and simulated plants.
//!
//! | module | what it holds | may use |
//! |---|---|---|
//! | [`dynamics`] | rigid-body dynamics of open trees | |
//! | [`models`] | robots: kinematics, limits, shapes, masses, motors and transmissions | dynamics |
//! | [`sensors`] | the kind of a force sensor at a wrist, and the wrench that robots tell themselves | |
//! | [`simulation`] | simulated drives, and bodies that simulated arms hold | dynamics, models, sensors |
//! | [`clearance`] | how near arms come to one another, and to obstacles | models |
//! | [`conformance`] | tests that every robot must pass, of this crate or another | models |
//!
//! The types that are used most are also exported here. Drives of real robots are crates beside this one
//! (`robots/drivers/`), which implement `mrroc::robot::Driver` for a model. The documentation of every robot has a
//! sketch of its frames, its limits and constants, and says where each figure comes from: public facts of MRROC++, or
//! an assumption, marked "assumed".
//!
//! | robot | joints | inverse kinematics |
//! |---|---|---|
//! | [`Irp6`] | 6 | closed form, 8 solutions |
//! | [`Irp6FiveDof`] | 5 | closed form, 4 solutions; the tool's axis stays in the arm's plane |
//! | [`Irp6Track`] | 1 + 6 | closed form; the track's position follows from a rule, or is given |
//! | [`Rnt`], with assumed dimensions | 6, two of them linear actuators | closed form through three closed loops |
//! | [`Polycrank`] | 7, endless | closed form, 8 families; the stretch is that of the seed, or is given |
//! | [`Gripper`], [`TwoFingers`], [`Conveyor`] | 1 | one solution |
//! | [`IoBlock`] | none: inputs and outputs alone | its place is the origin |
//! | [`Serial`], read from a URDF | 1 to 8 | closed form for ortho-parallel arms, UR-type arms and seven axes with spherical shoulder and wrist, else iteration |
//!
//! ```
//! use mrroc::robot::{Driver, Robot};
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
pub mod dynamics;
mod kinds;
pub mod models;
pub mod sensors;
pub mod simulation;

pub use kinds::{simulated, simulated_in, simulated_in_with, urdf_arm};
pub use models::mesh;
pub use models::{
    ArmCalibration, ChainCalibration, Conveyor, DisabledPair, Driven, Encoder, Five, Gains, Gripper, IoBlock,
    Irp6, Irp6Calibration, Irp6FiveDof, Irp6Track, Jacobian, Kinematics, Linear, LinkState, LocalCorrection,
    Meshes, MotorData, MotorLimits, NoCalibration, NoJoints, One, Openings, Overload, Polycrank, Rnt, Screw,
    Serial, SerialBuilder, SerialOutline, Seven, Shafts, Six, Transmission, TwoFingers, UrdfError, UrdfText,
};
pub use simulation::{
    Plant, Regulator, RegulatorSet, Shaft, Simulated, SimulatedIrp6, Surrounded, Surroundings, Unhomed, grasp,
};
