//! The template's common files as a project: the test that it brings, and its command line.

mod launch;
#[path = "../../template/tests/simulated.rs"]
mod simulated;
