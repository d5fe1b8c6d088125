//! Tests of the base: its drives, how well it follows a path, how it drifts, and what goes wrong.

mod bench;
mod drives;
mod faults;
mod following;
mod umbmark;
