//! The sorting task: what it keeps, and what faults do to it.

mod camera;
mod camera_faults;
mod checked;
mod empty_grips;
mod faults;
mod lines;
mod long;
mod matrix;
mod matrix_faults;
mod sorting;
mod two_arms;
