//! The planner as its users use it.

mod cells;
mod check;
mod plans;
mod stops;
