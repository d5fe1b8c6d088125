//! Motion generators for `mrroc`, and the mathematics under them.
//!
//! - [`generators`]: what a program hands to a Move, each in one file to be copied and changed;
//! - [`combinators`]: generators made of these;
//! - [`profile`]: how far along a path at which instant;
//! - [`jerk`]: jerk-limited motion from any state, on many axes at once;
//! - [`mod@line`]: straight lines of joints and of the tool;
//! - [`curve`]: arcs, helices, ellipses, screws, blended polylines, cubic splines;
//! - [`bspline`]: the moving-segment B-spline through a stream of points;
//! - [`feed`]: how fast along such a spline;
//! - [`timing`]: how fast along a given path of joints, in the least time;
//! - [`via`]: straight legs through via points within a stated deviation;
//! - [`teach`]: taught poses and their files, MRROC++'s too;
//! - [`cooperation`]: several arms on one body;
//! - [`force`]: how the axes of a tool move freely, are guarded, or keep a load;
//! - [`mod@conformance`]: tests that every generator must pass.
//!
//! Units are SI throughout; lengths in metres unless a path says otherwise. Stepping functions neither allocate nor
//! panic.
#![warn(missing_docs)]

// Generators name this crate as a user's copy of them does.
extern crate self as mrroc_generators;

pub mod bspline;
pub mod combinators;
pub mod conformance;
pub mod cooperation;
pub mod curve;
pub mod feed;
pub mod force;
pub mod generators;
pub mod jerk;
pub mod line;
pub mod profile;
pub mod teach;
pub mod timing;
pub mod via;
