//! Collision-free motions for one to four arms, planned so that their stops are clear as well.
//!
//! In: a [`Clearance`](mrroc_robots::clearance::Clearance), which is the world of the guard and of dry runs too, joint positions of all its
//! robots, and goals. Out: a [`Plan`], which [`FollowPlan`] moves robots along.
//!
//! ```text
//! Clearance --> Checker: eight postures at once, proofs between them
//!                  |
//! start, goals --> search: in turns, RRT-Connect, shortcuts --> Path: corners rounded --> timing: limits, stops --> Plan --> FollowPlan
//! ```
//!
//! While robots follow a plan, a [`Replanner`] makes another one, on a thread of its own.
//!
//! Nothing of this runs in a step but [`FollowPlan`], which evaluates the plan, and [`PlanGuard`], which watches robots that follow it. It is no certified safety function.
#![warn(missing_docs)]

mod arm;
mod balls;
mod beside;
mod body_space;
mod braking;
mod carry;
mod chain;
mod check;
mod closest;
mod cut;
mod edge;
mod encoding;
mod error;
mod fault_stops;
mod follow;
mod followed;
mod goals;
mod guard;
mod here;
mod lanes;
mod limits;
mod onward;
mod pairing;
mod path;
mod pieces;
mod plan;
mod plane;
mod planner;
mod proof;
mod reach;
mod replan;
mod replanner;
mod search;
mod speed;
mod stop;
mod timing;
mod twist;
mod upright;
mod via;

pub use carry::{Carried, CarriedPath};
pub use chain::Holders;
pub use closest::{Closest, ClosestTable, During, FaultStop};
pub use error::PlanError;
pub use follow::{FollowPlan, Following, Reached};
pub use goals::{goals_at, goals_turned};
pub use guard::{GuardError, PlanGuard, Watched};
pub use here::{Here, HereAll, Standing};
pub use plan::Plan;
pub use planner::Planner;
pub use replanner::{Replanned, Replanner};

// The files in `tests/` use this crate by its name, as its users do.
#[cfg(test)]
extern crate self as mrroc_planning;
#[cfg(test)]
#[path = "../tests/main.rs"]
mod usage;
