//! The planner as its users use it.

mod beside;
mod carry;
pub(crate) mod cells;
mod check;
mod examples;
mod guard;
mod models;
mod plans;
mod recorded;
mod replan;
mod roadmap;
mod several;
mod stops;
mod table;
mod upright;
mod via;

use mrroc_counting_allocator::Counting;

#[global_allocator]
static ALLOCATOR: Counting = Counting;
