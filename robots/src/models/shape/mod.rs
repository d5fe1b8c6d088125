//! The shape of a robot: its links as capsules, and how its joints move them.
//!
//! In: joint positions. Out: [`Capsule`]s in the world, one or more for each [`Link`], and the [`Motion`]s that move
//! them. A robot has a shape by implementing [`Outline`]. What is done with shapes stands elsewhere: `clearance` keeps
//! them apart.
//!
//! The shapes of this crate's arms stand beside their kinematics (`outline.rs`). Lengths are those of the kinematics.
//! **Radii are assumed**: no drawings of the covers are public; they were chosen to hold the links, drives and cables of
//! arms of this size. Scale them, or write an [`Outline`] of your own, for a real cell. The gripper is part of an arm's
//! tool, the conveyor an obstacle.

mod capsule;
mod chain;
mod frames;
mod outline;

pub use capsule::Capsule;
pub use chain::{Chain, ChainBody, ChainJoint};
pub(crate) use frames::{frames, origin, turn};
pub use outline::{Link, Motion, Outline};
