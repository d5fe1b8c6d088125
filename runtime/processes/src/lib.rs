//! Processes of the operating system: one executable is every process of a cell, and the launcher that starts them.
//!
//! [`launcher`] starts a [`session`], its [`crew`] of processes, each a [`member`] that puts the whole cell together and
//! runs its own part of it; [`control`] is what they tell each other besides the messages of the cell; [`desk`] is where the
//! operator's consoles connect, and [`board`] where processes show what they do, each on its [`panel`];
//! [`scheduling`] asks the machine for priorities, cores and memory, [`room`] whether there is room, and [`doctor`] what it can
//! do.

#![allow(
    clippy::disallowed_methods,
    reason = "launchers and consoles are no part of control, nor is a process whose cell is gone"
)]

mod board;
mod control;
mod crew;
mod desk;
mod doctor;
mod figures;
#[cfg(test)]
mod latency;
mod launcher;
mod member;
mod panel;
mod room;
mod scheduling;
mod session;

pub(crate) use crew::Plan;
#[cfg(feature = "view")]
pub(crate) use desk::{Asks, Hears, RobotPicture};
pub(crate) use desk::{Caller, Heard, MAX_REQUEST, Picture, Reply, Request};
pub(crate) use doctor::examine;
pub(crate) use figures::Figures;
pub(crate) use launcher::{LaunchError, Launched, launch};
pub(crate) use member::{NoPart, run};
#[cfg(all(feature = "view", test))]
pub(crate) use {desk::ProcessPicture, figures::Spread};
