//! A base with two driven wheels: the same programs that move arms move it.
//!
//! ```text
//! demanded wheel angles -> Rolling: regulators, geared motors -> Chassis: tyres that slip, a body among walls -> encoders
//! encoders, gyro, infrared sensors -> Whereabouts: where it stands, and which walls it sees
//! Path: straight pieces and clothoid corners -> FollowPath: wheel angles within all limits, corrected by where it stands
//! ```
//!
//! | module | what flows in, what flows out |
//! |---|---|
//! | [`model`] | wheel angles in; how far it has rolled and turned out: `mrroc::robot::Robot` |
//! | [`simulation`] | demanded wheel angles in; measured ones, and where the base truly is, out |
//! | [`sensing`] | wheel angles, a rate gyro's codes and infrared sensors' codes in; a pose and seen walls out |
//! | [`path`] | places in; a path of continuous curvature out |
//! | [`generators`] | a path and where the base stands in; demands out |

pub mod generators;
pub mod model;
pub mod path;
pub mod sensing;
pub mod simulation;

pub use generators::FollowPath;
pub use model::{DiffDrive, Two};
pub use path::Path;
pub use sensing::{Planar, Whereabouts};
pub use simulation::{Floor, Rolling};

// The files in `tests/` use this crate by its name, as its users do.
#[cfg(test)]
extern crate self as mrroc_wheels;
#[cfg(test)]
#[path = "../tests/main.rs"]
mod usage;
