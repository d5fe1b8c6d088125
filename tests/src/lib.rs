//! What the whole-system tests of `mrroc` share with the programs that they start.

pub mod fixture;

pub use mrroc_doubles::*;
