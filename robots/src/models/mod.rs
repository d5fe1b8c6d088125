//! Models of robots: kinematics, limits, shapes, and what is known of their drives. Nothing here has a state or a clock.
//!
//! In: joint positions, or a pose of the flange. Out: poses, Jacobians, all solutions of the inverse kinematics, links as
//! capsules, motor angles. A model serves programs, simulated drives and real drives alike, so it knows none of them.
//!
//! | trait | what a robot says by it |
//! |---|---|
//! | [`mrroc::robot::Robot`] | limits, `forward`, `inverse`: what the runtime needs |
//! | [`Kinematics`] | Jacobian, all solutions, distance to singularities |
//! | [`Driven`] | its motors, how they move the joints, and the masses of its links |
//! | [`Outline`] | its links as [`Capsule`]s, and what moves them |
//!
//! A robot is a file, or a folder where it is one of a family or has more to say: `irp6/`, `rnt.rs`, `polycrank.rs`,
//! `gripper.rs`, `two_fingers.rs`, `conveyor.rs`, `io_block.rs`; `urdf/` reads any serial chain. Three families of arms are solved in closed form: `opw.rs` (ortho-parallel),
//! `three_parallel.rs` (UR type) and `spherical.rs` (seven axes); `planar.rs` is what these have in common.
//! They share `base.rs` (where a robot stands), `xml.rs` (what is read of XML), `vectors.rs`, `drives.rs`, `shape/`, `mesh/` (meshes and capsules that cover them) and the numerics of `kinematics.rs`,
//! `singular.rs` and `sines.rs`. `calibration.rs` reads what was measured of one arm, `local.rs` corrects what dimensions cannot say of it.

mod base;
mod calibration;
mod conveyor;
mod drives;
mod gripper;
mod io_block;
mod irp6;
mod kinematics;
mod local;
pub mod mesh;
mod opw;
mod planar;
mod polycrank;
mod rnt;
mod shape;
mod sines;
mod singular;
mod spherical;
mod three_parallel;
mod two_fingers;
mod urdf;
mod vectors;
pub mod xml;

pub use calibration::{ArmCalibration, ChainCalibration, Irp6Calibration};
pub use conveyor::Conveyor;
pub(crate) use drives::GRAVITY;
pub use drives::{Driven, Encoder, Gains, MotorData, MotorLimits, Overload, Shafts};
pub use gripper::Gripper;
pub use io_block::{IoBlock, NoJoints};
pub use irp6::{Irp6, Irp6FiveDof, Irp6Track, Linear, LinkState, Screw, Transmission};
pub(crate) use kinematics::closest;
pub use kinematics::{Jacobian, Kinematics};
pub use local::{LocalCorrection, NoCalibration};
pub use polycrank::Polycrank;
pub use rnt::Rnt;
pub use shape::{Capsule, Chain, ChainBody, ChainJoint, Link, Motion, Outline};
pub use two_fingers::TwoFingers;
pub use urdf::{DisabledPair, Meshes, Openings, Serial, SerialBuilder, SerialOutline, UrdfError, UrdfText};
pub use vectors::{Five, One, Seven, Six};
