//! Tests of the runtime, one file for each promise.

mod aborting;
mod background;
mod bounds;
mod coordination;
mod determinism;
mod faults;
mod feed;
mod guards;
mod handles;
mod handover;
mod homing;
mod jerk;
pub mod kit;
mod lateness;
mod limits;
mod moves;
mod opening;
mod pairing;
mod panics;
mod path_stops;
mod rates;
mod regulators;
mod resetting;
mod sensors;
mod suspending;
mod sweeps;
mod waits;
