//! Simulated robots: drives down to their motors, their homing, and a body that several arms hold.
//!
//! In: demanded joint positions, one servo period after the other. Out: what the encoders measure. It needs of a robot
//! what [`Driven`](crate::Driven) says of its motors, and, in a [`grasp`] world, its kinematics:
//!
//! ```text
//! demanded q -> Driven -> Regulator (2 ms, per motor) -> Plant (motor and load) -> encoder
//!   measured q <------------------- Driven <-------------------------------------'
//! ```
//!
//! | file | concept |
//! |---|---|
//! | `plant.rs` | [`Plant`]: one motor with its load, integrated so that no energy is created; `plant/coupled.rs`: all of a robot, coupled by its links |
//! | `regulator.rs` | [`Regulator`]: the servo regulator of one motor, with three parameter sets |
//! | `simulated.rs` | [`Simulated`]: both, for every motor of a robot, as a `mrroc::robot::Driver` |
//! | `surroundings.rs` | [`Surrounded`]: drives among things that load their motors and are moved by them |
//! | `homing.rs` | [`Unhomed`]: drives that look for their reference marks first |
//! | `grasp/` | a rigid body that arms hold or that lies on a table, and the force sensors at their wrists |

pub mod grasp;
mod homing;
mod plant;
mod regulator;
mod simulated;
mod surroundings;

pub use homing::Unhomed;
pub use plant::Plant;
pub use regulator::{Regulator, RegulatorSet};
pub use simulated::{Shaft, Simulated, SimulatedIrp6};
pub use surroundings::{Surrounded, Surroundings};
