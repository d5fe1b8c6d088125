//! What SAFETY.md promises under faults, one folder for its rows: numbers in the tests' names are the rows'.

mod cells;
mod drives;
mod endless;
mod sensors;
mod summary;
mod sweeps;
mod tasks;
mod wall_clock;
