//! Motion generators for `mrroc`, and the mathematics under them.
//!
//! - [`generators`]: what a program hands to a Move, each in one file to be copied and changed;
//! - [`combinators`]: generators made of these;
//! - [`conditions`]: conditions made of conditions, for a Wait;
//! - [`profile`]: the distance along a path as a function of time;
//! - [`jerk`]: jerk-limited motion from any state, on many axes at once;
//! - [`mod@line`]: straight lines of joints and of the tool;
//! - [`curve`]: arcs, helices, ellipses, screws, blended polylines, cubic splines;
//! - [`bspline`]: the moving-segment B-spline through a stream of points;
//! - [`feed`]: the speed along such a spline;
//! - [`timing`]: the fastest motion along a given path of joints;
//! - [`trajectory`]: joint positions at times, as other programs plan them;
//! - [`via`]: straight legs through via points within a stated deviation;
//! - [`waypoints`]: which points of a path count;
//! - [`jogging`]: paths of a robot that a person jogs, checked before the robot goes along them;
//! - [`teach`]: taught poses and their files, also in the format of MRROC++;
//! - [`cooperation`]: several arms on one body;
//! - [`force`]: force control: each axis of a tool moves freely, is guarded, or keeps a load;
//! - [`spiral`]: the path of a search;
//! - [`ahead`]: places that a generator names before it comes to them;
//! - [`between`]: the displacement from one pose to another, as velocities of a tool are told;
//! - [`rehearsal`]: what a generator demands, without a cell;
//! - [`mod@conformance`]: tests that every generator must pass.
//!
//! All units are SI. Lengths are in metres unless a path says otherwise. Functions that are called in a step neither
//! allocate nor panic.
#![warn(missing_docs)]

// Generators refer to this crate by its name, so that a copy of them in a user's project compiles as it is.
extern crate self as mrroc_generators;

pub mod ahead;
pub mod between;
mod braked;
pub mod bspline;
pub mod combinators;
pub mod conditions;
pub mod conformance;
pub mod cooperation;
pub mod curve;
pub mod feed;
pub mod force;
pub mod generators;
pub mod jerk;
pub mod jogging;
pub mod line;
pub mod profile;
pub mod rehearsal;
pub mod spiral;
pub mod teach;
pub mod timing;
pub mod trajectory;
pub mod via;
pub mod waypoints;

// The files in `tests/` use this crate by its name, as its users do.
#[cfg(test)]
#[path = "../tests/main.rs"]
mod usage;
