//! The sorting task: what it keeps, and what faults do to it.

mod camera;
mod camera_faults;
mod faults;
mod judged;
mod lines;
mod matrix;
mod matrix_faults;
mod sorting;
mod two_arms;
