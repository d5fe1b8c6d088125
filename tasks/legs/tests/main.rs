//! The task of the legs: what it keeps, and what faults do to it.

mod faults;
mod leg;
mod physics;
mod runs;
