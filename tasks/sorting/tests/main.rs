//! The sorting task: what it keeps, and what faults do to it.

mod faults;
mod lines;
mod sorting;
