//! Motion generators for `mrroc`: the mathematics of motion, free of robots and of the runtime.
//!
//! - [`profile`]: how far along a path at which instant;
//! - [`mod@line`]: straight lines of joints and of the tool;
//! - [`bspline`]: the moving-segment B-spline through a stream of points;
//! - [`feed`]: how fast along such a spline.
//!
//! Units are SI throughout; lengths in metres unless a path says otherwise. Stepping functions neither allocate nor
//! panic.
#![warn(missing_docs)]

pub mod bspline;
pub mod feed;
pub mod line;
pub mod profile;
