//! Tests of the solver and of problems.

mod arms;
mod camera;
#[path = "support/case.rs"]
mod case;
mod chain;
mod data;
mod hand;
mod local;
mod own_arm;
mod postures;
mod problem;
