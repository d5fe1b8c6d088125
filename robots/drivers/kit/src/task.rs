//! What a session and the network that runs its protocol know of each other.
//!
//! In: the time, and what has come. Out: what is to be sent, and whether it goes on.

use core::fmt::Debug;
use core::time::Duration;

use crate::protocol::{NotConnected, Received};

/// A protocol of any kind, as what runs it sees it.
pub(crate) trait Task: Send {
    /// As [`Protocol::poll`](crate::Protocol::poll); `None` when it has ended.
    fn poll(&mut self, now: Duration, received: Received<'_>, send: &mut Vec<u8>) -> Option<Duration>;

    /// There is no connection.
    fn fail(&mut self, why: NotConnected);

    /// It was told to end.
    fn close(&mut self);
}

/// What runs a protocol. When it is dropped the protocol has ended.
pub(crate) trait Running: Debug + Send + Sync {
    /// The time since the session began.
    fn now(&self) -> Duration;

    /// Tells it to end, and returns.
    fn hang_up(&self);

    /// Whether it has ended.
    fn is_over(&self) -> bool;
}
