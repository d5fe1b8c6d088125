//! Robots for `mrroc`: kinematics, limits, transmissions and simulated plants.
//!
//! One robot is one file: [`Irp6`] holds the geometry, the limits, and the constants of its transmission
//! and of its drives. What a simulation adds is layered on top and knows nothing of kinematics:
//!
//! ```text
//! demanded q -> Transmission -> Regulator (2 ms, per motor) -> Plant (motor and load) -> encoder
//!   measured q <------------------- Transmission <-------------------------------------'
//! ```
//!
//! [`SimulatedIrp6`] ties them together as a `mrroc::Driver`. All figures marked "assumed" are stand-ins
//! for figures that are not public; the others are public facts of MRROC++.

pub mod conformance;
mod conveyor;
mod drives;
mod gripper;
mod irp6;
mod irp6_five;
mod irp6_track;
mod kinematics;
mod plant;
mod polycrank;
mod regulator;
mod rnt;
mod simulated;
mod singular;
mod transmission;
mod trig;
mod wrist;

pub use conveyor::Conveyor;
pub use drives::{Driven, MotorData, MotorLimits, Overload, Shafts};
pub use gripper::{Gripper, One};
pub use irp6::{Irp6, Six};
pub use irp6_five::{Five, Irp6FiveDof};
pub use irp6_track::{Irp6Track, Seven};
pub use kinematics::{Jacobian, Kinematics};
pub use plant::{Encoder, Plant};
pub use polycrank::Polycrank;
pub use regulator::{Gains, Regulator};
pub use rnt::Rnt;
pub use simulated::{Shaft, Simulated, SimulatedIrp6};
pub use transmission::{Linear, LinkState, Screw, Transmission};
