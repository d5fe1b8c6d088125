//! Whole-system tests, a folder per promise, in one executable: what they share is compiled and linked once.
//!
//! Tests that start processes in real time are in `processes/`, an executable of their own, so that tests that compute take
//! no processor from them.

mod allocation;
mod cell_file;
mod compiler;
mod layers;
mod library;
mod macros;
mod newcomer;
mod parsers;
mod programs;
mod readme;
mod recording;
mod runtime;
mod safety;
mod tutorial;
mod workspace;

/// What the files of a newcomer's project, which the tutorial's chapters compile where they lie, find at its root.
#[path = "../template/src/arm.rs"]
mod arm;
/// The copy of chapter 4, changed; it has a constructor more than the chapter calls.
#[allow(dead_code)]
#[path = "tutorial/4_own"]
mod generators {
    mod my_line;
    pub use my_line::MyLine;
}
#[path = "tutorial/3_tight/orders.rs"]
mod orders;

#[global_allocator]
static ALLOCATOR: mrroc_counting_allocator::Counting = mrroc_counting_allocator::Counting;
