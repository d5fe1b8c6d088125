//! A cell as processes of the operating system: the same demands to the bit, and no remains whatever is killed.
//!
//! The processes are those of the task programs in `tests/cell/`. Most tests run them in lock-step, where nothing can be late. Those of
//! `real_time` need the machine's clock; they hold on a machine that is late, too.

#![cfg(target_os = "linux")]

mod both_links;
mod consoles;
mod crowd;
mod identity;
mod kills;
mod launch;
mod lower_cells;
mod operator;
mod picture;
mod real_time;
mod rows;
mod runs;
mod sound;
