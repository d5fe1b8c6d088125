//! Connections in one process: what one end writes comes in at the other end at once.
//!
//! In: bytes, and the time. Out: the same bytes, and when they came. Neither end waits for the other.

use core::cell::RefCell;
use core::time::Duration;
use std::collections::VecDeque;
use std::io::{self, ErrorKind, Read, Write};
use std::rc::Rc;

/// The most bytes that wait at one end: about what sockets take.
const MOST: usize = 256 * 1024;

/// A clock that is set.
pub(crate) type Clock = Rc<core::cell::Cell<Duration>>;

/// What goes in one direction.
#[derive(Debug, Default)]
struct Direction {
    /// Each with when it came.
    bytes: VecDeque<(Duration, u8)>,
    is_closed: bool,
}

type Shared = Rc<RefCell<Direction>>;

/// One end of a connection, which is closed when it is let go.
#[derive(Debug)]
pub struct Pipe {
    clock: Clock,
    comes: Shared,
    goes: Shared,
}

impl Pipe {
    /// Both ends of a connection.
    pub(crate) fn pair(clock: &Clock) -> [Pipe; 2] {
        let (there, back) = (Shared::default(), Shared::default());
        let end = |comes: &Shared, goes: &Shared| Pipe {
            clock: Rc::clone(clock),
            comes: Rc::clone(comes),
            goes: Rc::clone(goes),
        };
        [end(&back, &there), end(&there, &back)]
    }

    /// Whether the other end may still write something.
    pub(crate) fn is_open(&self) -> bool {
        !self.comes.borrow().is_closed
    }

    /// Its connection, to see whether it is open.
    pub(crate) fn status(&self) -> Status {
        Status(Rc::clone(&self.comes))
    }

    /// The time.
    pub(crate) fn now(&self) -> Duration {
        self.clock.get()
    }

    /// Closes both directions.
    pub(crate) fn close(&self) {
        self.comes.borrow_mut().is_closed = true;
        self.goes.borrow_mut().is_closed = true;
    }

    /// What has come and is not read, in one piece.
    pub(crate) fn waiting(&self) -> Vec<u8> {
        self.comes.borrow().bytes.iter().map(|(_, byte)| *byte).collect()
    }

    /// Takes so many bytes of that, which are not none, and says when the last of them came.
    pub(crate) fn take_front(&self, len: usize) -> (Vec<u8>, Duration) {
        let mut direction = self.comes.borrow_mut();
        let taken: Vec<_> = direction.bytes.drain(..len).collect();
        let came = taken.last().map_or(Duration::ZERO, |(came, _)| *came);
        (taken.into_iter().map(|(_, byte)| byte).collect(), came)
    }
}

/// Whether a connection is open, for who has no end of it.
#[derive(Debug)]
pub(crate) struct Status(Shared);

impl Status {
    pub(crate) fn is_open(&self) -> bool {
        !self.0.borrow().is_closed
    }
}

impl Drop for Pipe {
    fn drop(&mut self) {
        self.close();
    }
}

impl Read for Pipe {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        let mut direction = self.comes.borrow_mut();
        if direction.bytes.is_empty() && !direction.is_closed {
            return Err(ErrorKind::WouldBlock.into());
        }
        let len = into.len().min(direction.bytes.len());
        for (place, (_, byte)) in into.iter_mut().zip(direction.bytes.drain(..len)) {
            *place = byte;
        }
        Ok(len)
    }
}

impl Write for Pipe {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let mut direction = self.goes.borrow_mut();
        if direction.is_closed {
            return Err(ErrorKind::BrokenPipe.into());
        }
        let len = bytes.len().min(MOST - direction.bytes.len());
        if len == 0 && !bytes.is_empty() {
            return Err(ErrorKind::WouldBlock.into());
        }
        let now = self.clock.get();
        direction.bytes.extend(bytes[..len].iter().map(|byte| (now, *byte)));
        Ok(len)
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_written_is_read_with_its_time_until_the_other_end_is_closed() {
        let clock = Clock::default();
        let [mut here, mut there] = Pipe::pair(&clock);
        let mut bytes = [0; 4];
        assert_eq!(there.read(&mut bytes).map_err(|why| why.kind()), Err(ErrorKind::WouldBlock));
        assert_eq!(here.write(b"abc").ok(), Some(3));
        clock.set(Duration::from_secs(1));
        assert_eq!(here.write(b"de").ok(), Some(2));
        assert_eq!(there.waiting(), b"abcde");
        assert_eq!(there.take_front(4), (b"abcd".to_vec(), Duration::from_secs(1)));
        drop(here);
        assert!(!there.is_open());
        assert_eq!((there.read(&mut bytes).ok(), bytes[0]), (Some(1), b'e'));
        assert_eq!(there.read(&mut bytes).ok(), Some(0));
        assert_eq!(there.write(b"x").map_err(|why| why.kind()), Err(ErrorKind::BrokenPipe));
    }

    #[test]
    fn an_end_that_reads_nothing_takes_no_more_at_last() {
        let [mut here, _there] = Pipe::pair(&Clock::default());
        assert_eq!(here.write(&vec![7; MOST + 1]).ok(), Some(MOST));
        assert_eq!(here.write(b"x").map_err(|why| why.kind()), Err(ErrorKind::WouldBlock));
    }
}
