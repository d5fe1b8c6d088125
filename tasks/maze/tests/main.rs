//! The maze task: what it keeps, and what faults do to it.

mod camera;
mod faults;
mod lines;
mod runs;
mod shared;
mod wheels;
