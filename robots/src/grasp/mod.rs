//! A rigid body as physics: grippers that hold it by springs, a table that it stands on, sensors that feel it.
//!
//! | file | concept |
//! |---|---|
//! | `body.rs` | a rigid body, and how it moves under forces |
//! | `compliance.rs` | a compliant grasp |
//! | `contact.rs` | a table |
//! | `hand.rs`, `world.rs` | grippers in the world; how the arms' servo periods drive it |
//! | `arm.rs` | the drives of an arm in the world |
//! | `fingers.rs` | a gripper that is a robot of its own |
//! | `internal.rs` | what grippers do to the body beyond carrying it |
//! | `wrist.rs` | the force and torque sensor at a wrist |

mod arm;
mod body;
mod compliance;
mod contact;
mod error;
mod fingers;
mod hand;
mod internal;
mod noise;
#[cfg(test)]
mod tests;
mod turn;
mod world;
mod wrist;

pub use arm::Grasping;
pub use body::{Body, BodyState};
pub use compliance::Grasp;
pub use contact::Table;
pub use error::{OutOfReach, WorldError};
pub use fingers::Fingers;
pub use internal::Sharing;
pub use world::{Hand, World};
pub use wrist::{SimulatedWrist, WristForce, WristOrder};
