//! A purely reactive controller: the arm leaves the maze by itself, by what it touches at the moment, without a map and without a plan.
//!
//! ```text
//! switch of the probe, seat, straight line to the exit -> touch, on its line or not (VSP) -> retreat, follow the wall, or head for the exit (ECP)
//! ```
//!
//! It is Bug2 (Lumelsky and Stepanov, *Path-planning strategies for a point mobile automaton moving amidst unknown obstacles of arbitrary
//! shape*, 1987) by touches: straight for the exit; where a wall is in the way along it, with the wall at the left, until the straight line is
//! met again and nearer to the exit. Two numbers are remembered: where it touched last on its line, and in which direction it goes.
//! [`sensor`] is the virtual sensor, [`ecp`] the controller, [`behaviours`] are those that are the task's own, [`mp`] starts it, [`run`] is one run.

pub mod behaviours;
pub mod ecp;
pub mod mp;
pub mod run;
pub mod sensor;
