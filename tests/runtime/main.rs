//! The runtime's promises, a file per promise.

mod aborting;
mod coordination;
mod faults;
mod feed;
mod handover;
mod kit;
mod moves;
mod sensors;
mod suspending;
mod waits;
