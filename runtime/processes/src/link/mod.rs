//! The iceoryx2 link: every process is a process of the operating system, and messages lie in shared memory.
//!
//! In: a cell, put together in every process alike, as on any other link. Out: the part of the cell that runs
//! in this process. A board is a blackboard, a port is two blackboards, and each process sleeps on one [`wake_futex`].
//! [`fabric`] puts the cell together, [`ports`] holds the ends of ports and boards in this process, and [`waiter`] lets a
//! process wait: in real time, or in lock-step under the launcher's virtual clock.

mod fabric;
mod management;
mod ports;
mod samples;
mod stand_in;
#[cfg(test)]
mod tests;
mod waiter;
mod wake_futex;

pub(crate) use fabric::{Fabric, LinkError};
pub(crate) use management::make_management;
pub(crate) use mrroc_core::link::Clock;
pub(crate) use mrroc_core::link::envelope::Seal;
pub(crate) use samples::Samples;
pub(crate) use stand_in::{Incoming, Outgoing, Seals, StandIn, Where};
pub(crate) use waiter::{Launcher, LauncherMessage, LockStep, RealTime, Shows, Slew, Supervised, monotonic};
pub(crate) use wake_futex::WakeFutex;
