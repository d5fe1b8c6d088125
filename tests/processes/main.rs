//! A cell as processes of the operating system: the same demands to the bit, and no remains whatever is killed.
//!
//! The processes are those of the task programs in `tests/cell/`. In real time they mostly wait, and must not be kept from
//! processors by tests that compute: they are an executable of their own, in which as many cells run at once as there are
//! processors.

#![cfg(target_os = "linux")]

mod both_links;
mod consoles;
mod crowd;
mod identity;
mod kills;
mod launch;
mod launches;
mod lower_cells;
mod operator;
mod picture;
mod rows;
mod runs;
mod soak;
mod supervision;
