//! Cells as processes of the operating system: one executable plays every process of a cell, and its launcher.
//!
//! In: a cell and a command line. Out: the run of all its processes, supervised by the launcher, or of the one process
//! that this is.
//!
//! A cell and its hardware are run once on a machine, by their `identity`. The `launcher` starts a `session` and its
//! `process_set`. In real time it keeps the cell under its `supervision`: it gives its `heartbeat`, hears `signals` of its
//! terminal, and `mp_watch` says when the MP stands still; under the virtual clock it resumes one process after another
//! (`pacing`). Each process is a `member`, which puts the whole cell together and runs its own part; `control` holds the
//! frames between the launcher and its processes. The operator's consoles connect to the `console_server`. Each process
//! shows what it does in its `entry` of the state `board`. A plant that draws a picture is shown what other processes have through
//! the `picture_socket`.
//! A cell may be on several machines: `nodes` has what carries its messages between them.
//! `scheduling` asks the machine for priorities, cores and locked memory, `capacity` checks that there is enough shared
//! memory and open files, and `doctor` says what the machine can do.

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
mod ending;
mod entry;
mod figures;
mod gauge;
mod heartbeat;
mod holding;
mod iceoryx;
mod identity;
mod latch_notes;
#[cfg(test)]
mod latency;
mod launcher;
mod member;
mod mp_watch;
mod nodes;
mod operating;
mod own_entry;
mod pacing;
mod part;
mod picture_socket;
mod process_set;
#[doc(hidden)]
pub mod readers;
mod scheduling;
mod session;
mod signals;
mod supervision;

pub use console_server::{
    BodyPicture, Caller, CarriedPicture, CellPicture, ConsoleMessage, ENDED, MAX_REQUEST, OnBehalf, Picture,
    ProcessPicture, ReadingPicture, Reply, ReplyReceiver, Request, RequestSender, RobotPicture,
};
pub use figures::{Figures, Spread};
pub use part::OverSharedMemory;
