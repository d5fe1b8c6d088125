//! Teach-in: positions that a person showed, as a file, to be edited and replayed.
//!
//! [`Jog`](crate::generators::Jog) records them, a [`TaughtFile`] keeps them whatever happens, [`Replay`](crate::generators::Replay) goes through them. A file is plain text, one
//! line per pose, `#` before comments:
//!
//! ```text
//! space joint                # joint, motor, zyz or angle-axis; lengths in m, angles in rad
//! reference absolute         # or relative: to the pose before, poses in its tool frame
//! # velocity acceleration : coordinates
//! 0.15 0.07 : 0 -1.57 0.16 -0.16 4.71 0
//! 0.15 0.07 : 0.2 -1.57 0.16 -0.16 4.71 0
//! ```
//!
//! A pose may have a name, by which a program asks for it, [`Taught::select`]: `pick = 0.15 0.07 : 0.2 -1.57 ..`. The operator's
//! panel keeps such files.
//!
//! Velocity and acceleration are shares of the largest ones, above 0 and up to 1. [`Taught::from_trj`] reads MRROC++'s `.trj`
//! files:
//!
//! ```text
//! JOINT                      MOTOR, JOINT, XYZ_EULER_ZYZ, XYZ_ANGLE_AXIS
//! 2                          poses
//! ABSOLUTE                   or RELATIVE
//! 0.15 0.15 ..               velocity, a share for each coordinate
//! 0.07 0.07 ..               acceleration, the same
//! 0 -1.57 ..                 coordinates
//! ```
//!
//! Words of the head may stand on one line. A pose is replayed with the least of its shares.

mod kept;
mod taught;
mod text;

pub use kept::{Kept, TaughtFile};
pub use taught::{Jogging, MAX_COORDINATES, Reference, Space, Taught, TaughtPose};
pub use text::BadFile;
