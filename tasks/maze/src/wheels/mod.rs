//! A base with two driven wheels as the effector: cells of contests' real size, walls that are seen before they are touched.
//!
//! Only what is different from an arm is here: [`ecp`] what the base does, [`sight`] what its sensor tells the
//! coordinator, [`plant`] the simulated base, and [`run`] one run. The coordinator, the map and the planner are those of the arm.

pub mod ecp;
pub mod plant;
pub mod run;
pub mod sight;

use mrroc_wheels::DiffDrive;

use crate::places::Sizes;

/// A base in a maze of contests' real size.
pub const CONTEST: Sizes = Sizes {
    pitch: 0.18,
    thickness: 0.012,
    radius: DiffDrive::BODY,
    margin: 0.012,
    back: 0.06,
    within: 0.04,
    passage: 0.15,
    velocity: 0.3,
    acceleration: 1.5,
};
