//! The planner as its users use it.

mod beside;
pub(crate) mod cells;
mod check;
mod examples;
mod guard;
mod plans;
mod recorded;
mod stops;
mod upright;
mod via;

use mrroc_counting_allocator::Counting;

#[global_allocator]
static ALLOCATOR: Counting = Counting;
