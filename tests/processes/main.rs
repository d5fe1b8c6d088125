//! A cell as processes of the operating system: the same demands to the bit, and no remains whatever is killed.
//!
//! The processes are those of the task programs in `tests/cell/`. The tests run one after another, in an executable of
//! their own, because in real time they need all processors.

#![cfg(target_os = "linux")]

mod both_links;
mod kills;
mod launch;
mod operator;
mod rows;
mod runs;
mod soak;
