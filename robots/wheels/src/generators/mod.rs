//! Generators for bases.

mod follow_path;
mod follower;

pub use follow_path::FollowPath;
pub use follower::{BaseLimits, Follower};
