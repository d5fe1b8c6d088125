//! Generators for bases.

mod follow_course;
mod follower;

pub use follow_course::FollowCourse;
pub use follower::{BaseLimits, Follower};
