//! Tests of what SAFETY.md promises under faults: the numbers in the tests' names are faults of docs/safety.

mod cells;
mod drives;
mod endless;
mod operators;
#[cfg(target_os = "linux")]
mod overflow;
mod sensors;
mod states;
mod summary;
mod sweeps;
mod tasks;
mod wall_clock;
mod wires;
