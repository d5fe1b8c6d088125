//! How fast along a path: a feed planner over a stream of spans.
//!
//! In: [`PathSpan`](crate::bspline::PathSpan)s, one at a time, and [`FeedLimits`]. Out: a [`PathPoint`] per increment
//! of path time. The path is cut into *cells* with one speed limit each:
//!
//! ```text
//! v <= F                                    feed
//! v <= sqrt(A_n rho)                        normal acceleration
//! v <= (2 / Ts) sqrt(2 rho d - d^2)         chord error d of a step Ts
//! v <= (J / |p_sss|)^(1/3)                  jerk at constant speed (optional, sampled)
//! ```
//!
//! `rho` is the least radius of the whole cell by a bound, not by samples: with `w` the cell's width,
//! `|f(u)| <= max at the ends + w^2/8 sup |f''|` for `f = S' x S''`, and likewise `|S'|` from below; a span with a cell
//! whose bound is more than 5 % above the curvature at its ends is cut into twice as many, sixteen at most. Where the
//! curvature goes on from cell to cell, the limit of `v^2` is a line from join to join, below both cells' limits: the speed
//! follows the curvature without chatter. Inside a cell the speed is the fastest trapezoid of `v^2` over the length under
//! that line, `|dv/dt| <= A_t`; a backward pass over the known cells, at rest behind the last of them, leaves it always
//! able to stop on the path. So `|a| <= sqrt(A_t^2 + A_n^2)` holds at every instant, not only at samples; and since only
//! path time is advanced, any feed override visits the same path.

mod cell;
mod limits;
mod path;
mod planner;
mod trapezoid;

pub use limits::{FeedError, FeedLimits};
pub use path::FedPath;
pub use planner::{FeedPlanner, PathPoint};
