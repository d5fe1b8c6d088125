//! Processes of the operating system: one executable is every process of a cell, and the launcher that starts them.
//!
//! [`launcher`] starts a [`session`], its [`process_set`], each a [`member`] that puts the whole cell together and
//! runs its own part of it; [`control`] is what they tell each other besides the messages of the cell; [`console_server`] is where the
//! operator's consoles connect, and [`board`] where processes show what they do, each in its [`entry`];
//! [`scheduling`] asks the machine for priorities, cores and memory, [`capacity`] whether there is enough memory and files for it, and [`doctor`] what it can
//! do.

#![cfg(target_os = "linux")]
#![allow(
    clippy::disallowed_methods,
    reason = "launchers and consoles are no part of control, nor is a process whose cell is gone"
)]

mod board;
mod capacity;
mod console_server;
mod control;
mod doctor;
mod entry;
mod figures;
mod iceoryx;
#[cfg(test)]
mod latency;
mod launcher;
mod member;
mod operating;
mod part;
mod process_set;
#[doc(hidden)]
pub mod readers;
mod scheduling;
mod session;

pub use console_server::{
    Asks, Caller, Heard, Hears, MAX_REQUEST, Picture, ProcessPicture, Reply, Request, RobotPicture,
};
pub use figures::{Figures, Spread};
pub use part::{OverSharedMemory, View};
