//! Jerk-limited motion from any state: the fastest, or of a given duration, on one axis or on many that arrive together.
//!
//! In: the state of each axis (position, velocity, acceleration), its target (the same) and
//! its limits of velocity, acceleration and jerk, which may differ by direction. Out: position, velocity, acceleration
//! and jerk at any instant of path time, exactly, and the extreme values that each takes.
//!
//! - [`AxisPlan`]: the shortest duration of one axis, which longer ones are impossible, and a [`JerkProfile`] of any other;
//! - [`SynchronisedMove`]: many axes in one duration, along a straight line where start, target and limits allow it;
//!   no shorter than a [`MoveDuration`] asks for, or in whole steps;
//! - [`MoveCursor`]: such a motion followed in increments of path time, which may turn to another target at any instant.
//!
//! The fastest motion has at most seven phases; one of another duration is a mixture of the two extremal motions of that
//! duration, hence of at most fourteen. Accuracy: the target is met exactly at the end; the motion leading there
//! misses it by less than 1e-9 of the numbers it was computed from, or the plan is refused.
//!
//! A start outside its limits, or one that cannot help leaving them, is first brought back within them, as in Ruckig; the
//! motion to the target begins there. A target outside its limits, or one that can only be reached from outside, is refused.
//!
//! Literature: Kröger, *On-Line Trajectory Generation in Robotic Systems* (2010); Berscheid and Kröger, *Jerk-limited
//! Real-time Trajectory Generation with Arbitrary Target States* (RSS 2021), whose durations these equal. The
//! extremal motions in place of its case trees are this library's own.

mod cursor;
mod extremal;
mod limits;
mod plan;
mod profile;
mod recovery;
mod rest;
mod synchronised;

pub use cursor::MoveCursor;
pub use limits::{AxisLimits, AxisState, AxisTarget, JerkError};
pub use plan::AxisPlan;
pub use profile::{AxisPoint, JerkProfile, Peaks};
pub use synchronised::{JointLimits, JointPoint, JointState, JointTarget, MoveDuration, SynchronisedMove};
