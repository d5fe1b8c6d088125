//! Processes of the operating system: one executable is every process of a cell, and the launcher that starts them.
//!
//! [`launcher`] starts a [`session`], its [`crew`] of processes, each a [`member`] that puts the whole cell together and
//! runs its own part of it; [`control`] is what they tell each other besides the messages of the cell; [`desk`] is where the
//! operator's consoles connect, and [`board`] where processes show what they do, each on its [`panel`];
//! [`scheduling`] asks the machine for priorities, cores and memory, [`room`] whether there is room, and [`doctor`] what it can
//! do.

#![cfg(target_os = "linux")]
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
mod iceoryx;
#[cfg(test)]
mod latency;
mod launcher;
mod member;
mod operating;
mod panel;
mod part;
#[doc(hidden)]
pub mod readers;
mod room;
mod scheduling;
mod session;

pub use desk::{
    Asks, Caller, Heard, Hears, MAX_REQUEST, Picture, ProcessPicture, Reply, Request, RobotPicture,
};
pub use figures::{Figures, Spread};
pub use part::{OverSharedMemory, View};
