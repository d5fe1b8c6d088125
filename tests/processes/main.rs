//! A cell as processes of the operating system: the same demands to the bit, and a clean end whatever is killed.
//!
//! The processes are those of the task programs in `tests/cell/`. The tests run one after the other, and in an executable
//! of their own: in real time they need the processors for themselves.

#![cfg(target_os = "linux")]

mod both_links;
mod kills;
mod launch;
mod operator;
mod rows;
mod runs;
mod soak;
