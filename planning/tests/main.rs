//! The planner as its users use it.

mod cells;
mod check;
mod examples;
mod plans;
mod stops;
mod via;
