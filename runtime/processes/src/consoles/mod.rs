//! The operator's consoles, and the console server that connects them with a running cell.
//!
//! In: requests of any number of consoles, over a socket in the session's folder. Out: presses of buttons for the MP,
//! one of each kind at a time; answers that say in which step each press was carried out or refused; pictures of the
//! cell.
//!
//! [`Request`](mrroc_core::operator::Request) is what a console asks for, [`protocol`] what it hears, [`picture`] and [`beside`] the state of the
//! cell that is shown, with some values [`as_words`]. On the launcher's side [`service`] is the server's thread, [`handle`] the launcher's
//! handle of it, [`console`] one connection, [`mp_session`] what is asked of one MP, and [`presses`] how presses get to the MP and
//! back. [`caller`] is the console's side; [`operating`] is the console of the command line, and [`holding`] lets a key of its terminal
//! hold a cell.

mod as_words;
mod beside;
mod caller;
mod console;
mod handle;
mod holding;
mod mp_session;
mod operating;
mod picture;
mod presses;
mod protocol;
#[doc(hidden)]
pub mod readers;
mod service;

pub use beside::{BodyPicture, CarriedPicture, ReadingPicture};
pub use caller::{AnswerReceiver, Caller, ENDED, RequestSender};
pub(super) use handle::ConsoleServer;
pub(super) use operating::operate;
pub use picture::{CellPicture, Picture, ProcessPicture, RobotPicture};
pub(super) use presses::STOPPING;
pub use protocol::ConsoleMessage;
pub(super) use service::CONNECTIONS;
