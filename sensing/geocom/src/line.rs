//! Lines of text over a serial port, or anything else with a descriptor.

use std::fs::File;
use std::os::fd::AsFd;
use std::path::Path;
use std::time::{Duration, Instant};

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::fs::{Mode, OFlags, open};
use rustix::io::Errno;
use rustix::termios::{ControlModes, OptionalActions, tcgetattr, tcsetattr};

use crate::client::{Trouble, Wire};
use crate::protocol::LONGEST;

/// A connection, and what has come of the next line.
#[derive(Debug)]
pub struct Line<F> {
    connection: F,
    begun: Vec<u8>,
}

impl Line<File> {
    /// Opens a serial port, such as `/dev/ttyUSB0`, at a speed \[baud\], 8 bits, no parity, one stop bit.
    ///
    /// # Errors
    /// It cannot be opened, or is no serial port.
    pub fn open(port: impl AsRef<Path>, baud: u32) -> std::io::Result<Self> {
        let flags = OFlags::RDWR | OFlags::NOCTTY | OFlags::NONBLOCK | OFlags::CLOEXEC;
        let port = open(port.as_ref(), flags, Mode::empty())?;
        let mut modes = tcgetattr(&port)?;
        modes.make_raw();
        modes.control_modes |= ControlModes::CREAD | ControlModes::CLOCAL;
        modes.control_modes &= !(ControlModes::CSTOPB | ControlModes::CRTSCTS);
        modes.set_speed(baud)?;
        tcsetattr(&port, OptionalActions::Now, &modes)?;
        Ok(Self::over(File::from(port)))
    }
}

impl<F: AsFd> Line<F> {
    /// Over something that is open.
    #[must_use]
    pub const fn over(connection: F) -> Self {
        Self { connection, begun: Vec::new() }
    }

    /// Waits until it can be read from or written to; `false` if the time is over.
    fn is_ready(&self, how: PollFlags, until: Instant) -> Result<bool, Trouble> {
        let left = until.saturating_duration_since(Instant::now());
        let Ok(left) = Timespec::try_from(left) else { return Err(Trouble::Closed) };
        match poll(&mut [PollFd::new(&self.connection, how)], Some(&left)) {
            Ok(ready) => Ok(ready > 0),
            Err(Errno::INTR) => Ok(false),
            Err(_) => Err(Trouble::Closed),
        }
    }
}

impl<F: AsFd> Wire for Line<F> {
    fn send(&mut self, line: &str) -> Result<(), Trouble> {
        let text = format!("{line}\r\n");
        let (mut rest, until) = (text.as_bytes(), Instant::now() + Duration::from_secs(2));
        while !rest.is_empty() {
            let is_ready = self.is_ready(PollFlags::OUT, until)?;
            if Instant::now() >= until {
                return Err(Trouble::Silent);
            }
            if !is_ready {
                continue;
            }
            match rustix::io::write(&self.connection, rest) {
                Ok(0) => return Err(Trouble::Closed),
                Ok(count) => rest = &rest[count.min(rest.len())..],
                Err(Errno::AGAIN | Errno::INTR) => {}
                Err(_) => return Err(Trouble::Closed),
            }
        }
        Ok(())
    }

    fn receive(&mut self, patience: Duration) -> Result<Option<String>, Trouble> {
        let (until, mut empty) = (Instant::now() + patience, 0);
        loop {
            if let Some(end) = self.begun.iter().position(|byte| matches!(byte, b'\n' | b'\r')) {
                let line: Vec<u8> = self.begun.drain(..=end).take(end).collect();
                if line.is_empty() {
                    empty += 1;
                    if empty > LONGEST {
                        return Err(Trouble::Garbled);
                    }
                    continue;
                }
                return Ok(Some(String::from_utf8_lossy(&line).into_owned()));
            }
            if self.begun.len() > LONGEST {
                self.begun.clear();
                return Err(Trouble::Garbled);
            }
            if !self.is_ready(PollFlags::IN, until)? {
                if Instant::now() >= until {
                    return Ok(None);
                }
                continue;
            }
            let mut bytes = [0; 256];
            match rustix::io::read(&self.connection, &mut bytes) {
                Ok(0) | Err(Errno::IO) => return Err(Trouble::Closed),
                Ok(count) => self.begun.extend_from_slice(&bytes[..count]),
                Err(Errno::AGAIN | Errno::INTR) => {}
                Err(_) => return Err(Trouble::Closed),
            }
        }
    }
}
