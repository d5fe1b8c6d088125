//! What drivers of robots on a network share: sockets for one robot alone, and sessions with devices, that never block its servo periods.
//!
//! In: the address of this machine on the robot's network, and the robot's. Out: what the robot sends, with how long it has been
//! here; how much came of others, too long, or was never read. A driver has its own protocol and nothing of sockets.
//!
//! | robot | helper |
//! |---|---|
//! | sends datagrams | [`Guest`] |
//! | is called, and sends over the connection | [`Line`] |
//! | calls | [`RobotListener`], which gives a [`Line`] |
//! | answers when it likes | a [`Session`], which runs a [`Protocol`] beside the servo periods; its [`Exchange`] has the newest reading, and connects again at a reset |
//! | sends lines of text, as many sensors do, over TCP or a serial line | [`Lines`], which connects again whenever that is needed |
//!
//! A [`Protocol`] is a state machine: it is given the time and what has come, and gives what is to be sent. Its [`Session`] runs it over
//! sockets in a thread; the feature `testing` adds a virtual network, on which tests run it against a model of the device under a
//! virtual clock.

mod exchange;
mod lines;
mod number;
mod protocol;
mod serial;
mod session;
mod sockets;
mod speed;
mod talk;
mod task;
mod tcp;
#[cfg(any(test, feature = "testing"))]
pub mod testing;
mod times;
mod udp;

pub use exchange::Exchange;
pub use lines::{Lines, NoLines};
pub use number::Number;
pub use protocol::{NotConnected, Peer, Protocol, Received};
pub use serial::Serial;
pub use session::{Network, Session};
pub use speed::Speed;
pub use talk::{Handed, Talk, Watch};
pub use tcp::{Cut, Cutting, Frame, Line, MAX_FRAME, RefusedCounts, RobotListener};
pub use times::Times;
pub use udp::{Arrived, Counted, Datagram, Guest, MAX_DATAGRAM};
