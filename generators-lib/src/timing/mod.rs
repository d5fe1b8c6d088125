//! How fast a given path of joints can be traversed: in the least time within limits of velocity, of acceleration, and of
//! whatever else is linear in the path's acceleration and the square of its speed, such as torques.
//!
//! In: a path `q(s)`, a grid on it, limits. Out: [`TimeOptimal`], a [`Profile`](crate::profile::Profile) of `s`.
//!
//! ```text
//! q'' = q_s u + q_ss x,   u = s'',  x = s'^2,  dx/ds = 2 u        every limit:  low <= a(s) u + b(s) x <= high
//! K_i = { x : a u exists within the limits that leads from x at s_i into K_i+1 }       backwards, K_N the speed asked for
//! u_i = the largest that leads from x_i into K_i+1                                     forwards
//! ```
//!
//! On a cell of the grid `u` is constant and `x` linear in `s`. A limited quantity is then a function of `s` on the cell, an
//! acceleration a parabola where the path is cubic; it is kept within its limits at its control points, whose hull it does
//! not leave: **limits hold between grid points as well**, exactly on cubic splines whose knots are on the grid ([`grid`]), to
//! the third order of the cell on other paths. Further limits, such as torques, are kept as those of cubics, to the fourth
//! order: with 5, 10, 20 cells from knot to knot of random paths, torques of two links exceed their limits by less than
//! 1e-4, 1e-5, 1e-6 of them. That costs time of the second order of the cell: less than 3 / n^2 of TOPPRA's duration on the
//! same n cells per knot span.
//! The set `K_i` is an interval, its ends the solutions of linear programmes in `(u, x)`, found by Newton's iteration along
//! the edges of the feasible set, which ends in finitely many steps. Where a joint reverses (`q_s = 0`, "zero inertia"),
//! the limits at both ends of the cell keep `u` from chattering; where all joints do, speed is limited by the cell's other end.
//!
//! [`joint_spline`] makes the path of a tool one of the joints. Literature: Pham and Pham, *A New Approach to Time-Optimal
//! Path Parameterization Based on Reachability Analysis* (TRO 2018); its implementation TOPPRA is what tests compare with.

mod cell;
mod grid;
mod inverse;
mod limits;

mod plan;
mod speeds;

pub use grid::grid;
pub use inverse::joint_spline;
pub use limits::{LinearLimit, PathLimits, TimingError, torque_limits};

pub use plan::TimeOptimal;
