//! Processes of the operating system: one executable is every process of a cell, and the launcher that starts them.
//!
//! [`launcher`] starts a [`session`], its [`crew`] of processes, each a [`member`] that puts the whole cell together and
//! runs its own part of it; [`control`] is what they tell each other besides the messages of the cell;
//! [`scheduling`] asks the machine for priorities, cores and memory, and [`doctor`] what it can do.

mod control;
mod crew;
mod doctor;
mod figures;
#[cfg(test)]
mod latency;
mod launcher;
mod member;
mod scheduling;
mod session;

pub(crate) use crew::Plan;
pub(crate) use doctor::examine;
pub(crate) use launcher::{LaunchError, launch};
pub(crate) use member::{NoPart, run};
