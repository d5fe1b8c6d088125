//! What drivers of robots on a network share: sockets for one robot alone, that never block its servo periods.
//!
//! In: the address of this machine on the robot's network, and the robot's. Out: what the robot sends, with how long it has been
//! here; how much came of others, too long, or was never read. A driver has its own protocol and nothing of sockets.

mod udp;

pub use udp::{Counted, Datagram, Guest, MAX_DATAGRAM};
