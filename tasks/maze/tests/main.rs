//! The maze task: what it keeps, and what faults do to it.

mod camera;
mod faults;
mod force;
mod lines;
mod reactive;
mod runs;
mod shared;
mod wheels;
