//! The runtime's promises, a file per promise.

mod coordination;
mod faults;
mod feed;
mod kit;
mod moves;
mod sensors;
mod waits;
