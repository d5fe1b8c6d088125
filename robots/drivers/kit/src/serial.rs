//! Serial lines of this machine.

use std::fs::{File, OpenOptions};
use std::io;
use std::os::unix::fs::OpenOptionsExt;
use std::path::PathBuf;

use rustix::fs::OFlags;
use rustix::termios::{ControlModes, OptionalActions, tcgetattr, tcsetattr};

/// A serial line: 8 bits, no parity, one stop bit, no flow control.
///
/// ```
/// use mrroc_driver_kit::Serial;
///
/// let nowhere = Serial { path: "/dev/no-such-line".into(), baud: 9600 };
/// assert_eq!(nowhere.open().map_err(|why| why.kind()).err(), Some(std::io::ErrorKind::NotFound));
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Serial {
    /// Its device file.
    pub path: PathBuf,
    /// Bits per second.
    pub baud: u32,
}

impl Serial {
    /// Opens it: nothing is done to what comes, and what came before is dropped. Neither reading nor writing waits.
    ///
    /// # Errors
    /// There is none, nobody may open it, it is no serial line, or it does not know this baud rate.
    pub fn open(&self) -> io::Result<File> {
        // Not the terminal that controls this program, and without waiting for a modem.
        let flags = OFlags::NOCTTY | OFlags::NONBLOCK;
        let file = OpenOptions::new()
            .read(true)
            .write(true)
            .custom_flags(flags.bits().cast_signed())
            .open(&self.path)?;
        let mut settings = tcgetattr(&file)?;
        settings.make_raw();
        settings.set_speed(self.baud)?;
        settings.control_modes |= ControlModes::CLOCAL | ControlModes::CREAD;
        settings.control_modes -= ControlModes::CSTOPB | ControlModes::CRTSCTS;
        tcsetattr(&file, OptionalActions::Flush, &settings)?;
        Ok(file)
    }
}

#[cfg(test)]
mod tests {
    use std::io::Write;

    use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};

    use super::*;
    use crate::Lines;

    /// A pseudo-terminal: what is written into one end comes out of the other one as out of a serial line.
    #[test]
    fn lines_come_over_a_serial_line_and_one_that_is_pulled_is_told() {
        let device = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY).expect("a pseudo-terminal");
        grantpt(&device).and_then(|()| unlockpt(&device)).expect("its other end");
        let name = ptsname(&device, Vec::new()).expect("its other end").into_string().expect("text");
        let mut device = File::from(device);
        let mut lines =
            Lines::over_serial(&name, 115_200).asked_every(core::time::Duration::from_millis(5), "?");
        lines.open().expect("it is there");
        device.write_all(b"0.153\r\n").expect("written");
        let line = loop {
            if let Some(line) = lines.next_line() {
                break line;
            }
            std::thread::yield_now();
        };
        assert_eq!(line, "0.153");
        drop(device);
        while lines.state().is_ok() {
            std::thread::yield_now();
        }
    }
}
