//! Sensors over a belt of a simulated world (feature `simulation`): what lies in it as physics is what they see.
//!
//! A [`Workpiece`] is what physics carries and what light meets, in one; [`OverBelt`] puts workpieces into a
//! [`World`](mrroc_robots::grasp::World) and shows them to the sensors of this crate.

mod over_belt;
mod workpiece;

pub use over_belt::{OverBelt, solid};
pub use workpiece::Workpiece;
