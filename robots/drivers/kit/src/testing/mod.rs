//! Models of devices at the other end of a connection, for tests of drivers.
//!
//! In: a [`Device`], which is given the time and what it was sent, as a [protocol](crate::Protocol) is. Out: a [`VirtualNetwork`] on which
//! sessions meet it under a virtual clock, deterministically and with faults of the network; or a [`Server`] on which they meet it in real
//! time.

mod device;
mod server;
mod virtual_network;

pub use device::{Device, Reply};
pub use server::{Server, unused_address};
pub use virtual_network::{Faults, VirtualNetwork};

#[cfg(test)]
mod tests;
