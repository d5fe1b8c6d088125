//! The console server: a running cell as its operator's consoles see it.
//!
//! In: requests of any number of consoles, over a socket in the session's folder. Out: presses of buttons for the MP, one at
//! a time of each kind; answers that say in which step each was carried out or refused; pictures of the cell.
//! [`protocol`] is what the two sides write, [`picture`] what the cell looks like, [`service`] the launcher's side, of
//! which [`handle`] is what the launcher holds, [`console`] one connection and [`presses`] the way to the MP; [`caller`] is
//! the other side.

mod caller;
mod console;
mod handle;
mod picture;
mod presses;
mod protocol;
mod service;

pub use caller::{Asks, Caller, Hears};
pub(super) use handle::ConsoleServer;
pub use picture::{Picture, ProcessPicture, RobotPicture};
pub use protocol::{Heard, MAX_REQUEST, Reply, Request};
