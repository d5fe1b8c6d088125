//! The planner as its users use it.

mod beside;
pub(crate) mod cells;
mod check;
mod examples;
mod models;
mod plans;
mod recorded;
mod several;
mod stops;
mod table;
mod upright;
mod via;
