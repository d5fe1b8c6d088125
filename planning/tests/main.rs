//! The planner as its users use it.

mod cells;
mod check;
mod examples;
mod models;
mod plans;
mod recorded;
mod several;
mod stops;
mod table;
mod via;
