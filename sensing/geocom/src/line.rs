//! A serial port, or anything else with a descriptor: bytes there and back.

use std::fs::File;
use std::os::fd::AsFd;
use std::path::Path;
use std::time::Duration;

use mrroc_driver_kit::Serial;
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::io::Errno;

use crate::action::GeocomError;

/// A serial port that is open.
#[derive(Debug)]
pub struct Line<F> {
    port: F,
}

impl Line<File> {
    /// Opens a serial port, such as `/dev/ttyUSB0`, at a speed \[baud\], 8 bits, no parity, one stop bit.
    ///
    /// # Errors
    /// It cannot be opened, or is no serial port.
    pub fn open(port: impl AsRef<Path>, baud: u32) -> std::io::Result<Self> {
        Serial { path: port.as_ref().to_owned(), baud }.open().map(Self::over)
    }
}

impl<F: AsFd> Line<F> {
    /// Over something that is open.
    #[must_use]
    pub const fn over(port: F) -> Self {
        Self { port }
    }

    /// Sends some of these bytes, as soon as any can be: how many; none if none could be sent in time.
    ///
    /// # Errors
    /// [`GeocomError::Closed`].
    pub fn send(&mut self, bytes: &[u8], time: Duration) -> Result<usize, GeocomError> {
        if !self.is_ready(PollFlags::OUT, time)? {
            return Ok(0);
        }
        match rustix::io::write(&self.port, bytes) {
            Ok(0) if !bytes.is_empty() => Err(GeocomError::Closed),
            Ok(count) => Ok(count),
            Err(Errno::AGAIN | Errno::INTR) => Ok(0),
            Err(_) => Err(GeocomError::Closed),
        }
    }

    /// Reads what comes, as soon as it does: how many bytes; none if none came in time, or it was woken by a signal.
    ///
    /// # Errors
    /// [`GeocomError::Closed`].
    pub fn receive(&mut self, bytes: &mut [u8], time: Duration) -> Result<usize, GeocomError> {
        if !self.is_ready(PollFlags::IN, time)? {
            return Ok(0);
        }
        match rustix::io::read(&self.port, bytes) {
            Ok(0) | Err(Errno::IO) => Err(GeocomError::Closed),
            Ok(count) => Ok(count),
            Err(Errno::AGAIN | Errno::INTR) => Ok(0),
            Err(_) => Err(GeocomError::Closed),
        }
    }

    /// Waits until it can be read from or written to; `false` if the time is over.
    fn is_ready(&self, how: PollFlags, time: Duration) -> Result<bool, GeocomError> {
        let Ok(time) = Timespec::try_from(time) else { return Err(GeocomError::Closed) };
        match poll(&mut [PollFd::new(&self.port, how)], Some(&time)) {
            Ok(ready) => Ok(ready > 0),
            Err(Errno::INTR) => Ok(false),
            Err(_) => Err(GeocomError::Closed),
        }
    }
}
