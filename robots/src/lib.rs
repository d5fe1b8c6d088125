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

mod irp6;
mod opw;
mod plant;
mod regulator;
mod simulated;
mod sines;
mod transmission;
mod urdf;
mod wrist;

pub use irp6::{Irp6, MotorData, Six};
pub use plant::{Encoder, Plant};
pub use regulator::{Gains, Regulator};
pub use simulated::{Shaft, SimulatedIrp6};
pub use transmission::{Linear, LinkState, Screw, Transmission};
pub use urdf::{Serial, SerialBuilder, UrdfError};
