//! One process of a cell, as it takes part.
//!
//! In: the session's folder, and frames of the launcher. Out: the run of this process's part of the cell (`run`), its entry on the
//! state board ([`own_entry`]), its figures ([`gauge`]), and to the launcher how its part ended.

mod gauge;
mod own_entry;
mod run;

pub(crate) use run::{NoPart, run};
