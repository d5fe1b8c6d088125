//! What drivers of robots on a network share: sockets for one robot alone, that never block its servo periods.
//!
//! In: the address of this machine on the robot's network, and the robot's. Out: what the robot sends, with how long it has been
//! here; how much came of others, too long, or was never read. A driver has its own protocol and nothing of sockets.
//!
//! | robot | helper |
//! |---|---|
//! | sends datagrams | [`Guest`] |
//! | is called, and sends over the connection | [`Line`] |
//! | calls | [`Door`], which gives a [`Line`] |
//! | answers when it likes | [`Talk`], a thread of its own; [`recall`] calls it again at a reset |

mod recall;
mod talk;
mod tcp;
mod udp;

pub use recall::{Recalled, recall};
pub use talk::{Handed, Number, Speed, Talk, Watch};
pub use tcp::{Cut, Cutting, Door, Frame, Line, MAX_FRAME, Refused};
pub use udp::{Counted, Datagram, Guest, MAX_DATAGRAM};
