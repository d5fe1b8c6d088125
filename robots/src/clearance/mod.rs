//! Arms do not collide: capsules around links, tools, bodies and obstacles, and how near they come.
//!
//! In: the states of all robots of a cell. Out: the two bodies that are nearest to one another, or [`TooClose`].
//!
//! ```text
//! Outline (links as capsules, motions) --.
//! tools, grasped bodies (capsules in F) --+-> Clearance --- check ---> a guard: protective stop on the path
//! Obstacle (table, box, cloud, ..) -------'       '------ DryRun ---> smallest distance of a whole run
//! ```
//!
//! **In motion.** [`Clearance::check`] is made for the guard of a cell:
//!
//! ```
//! use std::time::Duration;
//! use mrroc::prelude::*;
//! use mrroc_robots::clearance::{Clearance, Obstacle, Stopping};
//! use mrroc_robots::{Irp6, Rnt};
//!
//! # fn cell() -> Result<Cell, Box<dyn std::error::Error>> {
//! let step = Duration::from_millis(2);
//! let mut clearance = Clearance::with_margin(0.03)
//!     .robot("irp6", Irp6::nominal().with_base(Pose::translation(0.0, 0.0, 0.7)))?
//!     .robot("rnt", Rnt::new().with_base(Pose::translation(1.8, 0.0, 0.0)))?
//!     .obstacle("floor", Obstacle::table(0.0))?
//!     .build(Stopping::of_guard(step, 10))?;
//! let cell = Cell::new(step);
//! let cell = cell.guard(10, move |robots| clearance.check(robots).map(|_| ()).map_err(Fault::from));
//! # Ok(cell) }
//! # cell().unwrap();
//! ```
//!
//! It keeps the margins **where the robots stand after a stop**. Each joint `i` moves by at most `w_i` until then
//! ([`Stopping`]). As a product of exponentials about the axes as they are now, a point of a link behind joints 1 .. k
//! gets no farther from where it is than
//!
//! ```text
//! D_k+1 = 0,     D_i = D_i+1 + w_i (d_i + D_i+1)  for a turn,     D_i = D_i+1 + w_i  for a slide,
//! ```
//!
//! with `d_i` its distance from axis `i` now: the last joint moves it by at most the arc `w_k d_k`; each one before
//! moves what may have come nearer or farther by what those behind it did. So `distance - D_1(link) - D_1(other link)` is
//! never more than what is left, on the way too. Of two links of one robot only the joints between them count.
//!
//! **On a known path** a stop on the path goes nowhere else. [`Clearance::prove`] proves that a [`KnownPath`] keeps all margins up to some place, between
//! samples too, by the same bound from the middle of stretches that are as short as needed.
//!
//! **A world that changes.** [`Clearance::replace_obstacle`] puts another body in an obstacle's place, also in a step.
//!
//! **What it does not see.** The demanded state is looked at, which the drives follow some way behind; the capsules' radii of
//! this crate's arms are assumed; cables, people and everything that it was not given are not seen. This is no
//! certified safety function.

// Errors hold both bodies and their points; in a box they would have to be allocated within a step.
#![allow(clippy::result_large_err)]

mod along;
mod bits;
mod builder;
mod check;
mod cover;
mod dry_run;
mod error;
mod from_cell;
mod from_mesh;
mod gap;
mod gradient;
mod near;
mod nearest;
mod obstacle;
mod pairs;
mod parts;
mod placement;
mod posture;
mod replace;
mod search;
mod standing;
mod stopping;

pub use along::{Against, KnownPath};
pub use builder::ClearanceBuilder;
pub use check::Clearance;
pub use dry_run::{Closest, DryRun, smallest_distance};
pub use error::{CheckError, ClearanceError, Nearest, Side, TooClose};
pub use from_mesh::drawn_mesh;
pub use gap::Gap;
pub use obstacle::{Bodies, Cloud, HeightField, Obstacle, ObstacleError};
pub use parts::{CheckedPair, Partner, RobotPart};
pub use posture::{Joints, Shape, Stretch};
pub use stopping::{Pace, Stop, Stopping, braking_distance};

pub use crate::models::{Capsule, Chain, ChainBody, ChainJoint, Link, Motion, Outline};
