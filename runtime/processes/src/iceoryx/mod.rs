//! The iceoryx2 link: every process is one of the operating system, and messages lie in shared memory.
//!
//! In: a cell put together as on any other link, in every one of its processes alike. Out: the part of it that runs
//! here. A board is a blackboard, a port two of them, and each process sleeps on one [`wake_futex`].
//! [`fabric`] puts the cell together, [`ports`] are the ends that are here,
//! [`waiter`] how a process waits: in real time, or in lock-step under the launcher's virtual clock.

mod fabric;
mod ports;
mod samples;
#[cfg(test)]
mod tests;
mod waiter;
mod wake_futex;

pub(crate) use fabric::Fabric;
pub(crate) use mrroc_core::link::Clock;
pub(crate) use mrroc_core::link::envelope::Seal;
pub(crate) use samples::Samples;
pub(crate) use waiter::{Heard, Launcher, LockStep, RealTime, Show, monotonic};
pub(crate) use wake_futex::WakeFutex;
