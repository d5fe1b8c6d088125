//! `mrroc-new` as a newcomer meets it, and what becomes of what it makes.

mod generated;
mod generator;
mod project;
mod support;
