//! What the processes of a session show each other in shared memory.
//!
//! In: what each process does ([`entry`]), how punctual it is ([`figures`]), and that its launcher supervises ([`heartbeat`]). Out: the
//! newest of it, for whoever looks at the [`StateBoard`].

pub(crate) mod entry;
pub(crate) mod figures;
pub(crate) mod heartbeat;
mod state_board;

pub(crate) use state_board::StateBoard;
