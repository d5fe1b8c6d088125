//! Tests of the solver and of problems.

#[path = "support/case.rs"]
mod case;
mod chain;
mod data;
mod problem;
