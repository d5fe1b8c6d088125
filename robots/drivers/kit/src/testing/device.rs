//! A model of a device.

use core::time::Duration;

/// A model of a device that takes one connection at a time. It reads no clock and has no socket.
pub trait Device: Send + 'static {
    /// Somebody has connected. What was said over the connection before is over.
    fn connected(&mut self) {}

    /// Takes in bytes of the other end, cut anywhere, by `now`, the time since the device was switched on. Returns when it is to be
    /// polled again at the latest; [`Duration::MAX`] where it only answers.
    fn poll(&mut self, now: Duration, received: &[u8], reply: &mut Reply) -> Duration;
}

/// What a device sends at a poll.
#[derive(Debug, Default)]
pub struct Reply {
    /// Bytes over the connection.
    pub bytes: Vec<u8>,
    /// Datagrams to ports of the machine that has connected.
    pub datagrams: Vec<(u16, Vec<u8>)>,
    /// Whether it closes the connection after that.
    pub closes: bool,
}
