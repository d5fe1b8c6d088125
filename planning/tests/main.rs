//! The planner as its users use it.

mod beside;
mod cells;
mod check;
mod examples;
mod plans;
mod recorded;
mod stops;
mod via;
