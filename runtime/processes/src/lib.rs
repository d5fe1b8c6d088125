//! Cells as processes of the operating system: one executable plays every process of a cell, and its launcher.
//!
//! In: a cell and a command line. Out: the run of all its processes, supervised by the launcher, or of the one process
//! that this is.
//!
//! Its folders are layers: none imports what stands above it. From the lowest one up:
//!
//! - `machine`: a cell and its hardware are run once on a machine, with the priorities, cores and memory that it is granted;
//! - `session`: the files and the shared memory of one launch;
//! - `link`: the messages between processes, in shared memory;
//! - `board`: the state board, on which each process shows what it does, and the launcher its heartbeat;
//! - `control`: the frames between the launcher and its processes;
//! - `consoles`: the operator's consoles, and the console server, to which they connect;
//! - `launch`: the launcher starts a session and its processes, supervises them in real time or resumes one after another under the
//!   virtual clock, and reports how the run ended;
//! - `member`: a process of the cell puts the whole cell together and runs its own part;
//! - `nodes`: what carries the messages of a cell on several machines between these;
//! - `picture_socket`: shows a plant that draws a picture what other processes have;
//! - `diagnosis`: says what the machine can do;
//! - `part`: what the command line asks of all of them.

#![cfg(target_os = "linux")]
#![allow(
    clippy::disallowed_methods,
    reason = "launchers and consoles are no part of control, nor is a process whose cell is gone"
)]

mod board;
mod consoles;
mod control;
mod diagnosis;
mod launch;
mod link;
mod machine;
mod member;
mod nodes;
mod part;
mod picture_socket;
mod session;

pub use board::figures::{Figures, Spread};
#[doc(hidden)]
pub use consoles::readers;
pub use consoles::{
    AnswerReceiver, BodyPicture, Caller, CarriedPicture, CellPicture, ConsoleMessage, ENDED, Picture,
    ProcessPicture, ReadingPicture, RequestSender, RobotPicture,
};
pub use part::OverSharedMemory;
