//! Rigid bodies as physics: grippers that hold them by springs, a table or a belt that they stand on, a plate
//! with holes, sensors that feel them.
//!
//! | file | concept |
//! |---|---|
//! | `body.rs` | a rigid body, and how it moves under forces |
//! | `compliance.rs` | a compliant grasp |
//! | `contact.rs` | a table |
//! | `plate.rs` | a plate with round holes |
//! | `belt.rs` | a belt that carries bodies by friction |
//! | `entry.rs` | bodies that come, rest on a belt, and go into sinks |
//! | `motion.rs`, `hand.rs` | what drives move in the world; a gripper there |
//! | `stepping.rs`, `world.rs`, `grip.rs` | the state of a world, and how it goes on in time; the world; a gripper from outside |
//! | `drives.rs` | the drives of an arm, and of a conveyor, in the world |
//! | `fingers.rs`, `jaws.rs` | a gripper that is a robot of its own: closing on the one body; on whatever its pads touch |
//! | `pads.rs` | the pads of fingers |
//! | `internal.rs` | forces of grippers against one another |
//! | `wrist.rs` | the force and torque sensor at a wrist |
//! | `turn.rs` | rotation vectors |
//!
//! ```
//! use mrroc::prelude::*;
//! use mrroc::robot::Driver;
//! use mrroc_robots::grasp::{Body, Grasp, World};
//! use mrroc_robots::{Polycrank, Seven, Simulated};
//!
//! // The program's arm, and the true one: its base stands 1 mm aside.
//! let robot = Polycrank::new();
//! let truly = Polycrank::new().with_base(Pose::translation(1e-3, 0.0, 0.0));
//! let q = Seven::from([0.3, 1.2, -0.4, 0.5, 1.1, -0.3, 0.2]);
//! let world = World::new(&Body::block(2.0, [0.1, 0.1, 0.1]).at(robot.forward(&q)))?;
//! let mut arm = world.arm(Simulated::new(truly, &q), Grasp::new(5e4, 500.0))?;
//! arm.hand().close()?;
//! for _ in 0..1000 {
//!     arm.tick(&q)?;
//! }
//! let weight = arm.hand().reaction().force.norm();
//! assert!((weight - 2.0 * 9.80665).abs() < 0.1);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod belt;
mod body;
mod compliance;
mod contact;
mod drives;
mod entry;
mod error;
mod fingers;
mod grip;
mod hand;
mod internal;
mod jaws;
mod motion;
mod pads;
mod plate;
mod stepping;
#[cfg(test)]
mod tests;
mod turn;
mod world;
mod wrist;

pub use belt::Belt;
pub use body::{Body, BodyState};
pub use compliance::Grasp;
pub use contact::Table;
pub use drives::{Carried, Conveying, Grasping, Gripped};
pub use entry::{Sink, Whereabouts};
pub use error::WorldError;
pub use fingers::{Enclosed, Fingers};
pub use grip::{Hand, OutOfReach};
pub use internal::Sharing;
pub use jaws::{Jaws, Pressed};
pub use pads::{Pads, Touch};
pub use plate::{Hole, Plate};
pub use world::World;
pub use wrist::SimulatedWrist;
