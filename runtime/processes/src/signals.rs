//! The signals that a launcher hears from its terminal.
//!
//! In: Ctrl-C and its like, Ctrl-Z. Out: flags, and a descriptor that becomes readable when one of them is set. The first
//! Ctrl-C aborts, after which the cell closes, whatever its program does; the second one ends the launcher at once. Ctrl-Z
//! asks the launcher to suspend its cell and to stop.

use std::io::{self, Read};
use std::os::fd::{AsFd, BorrowedFd};
use std::os::unix::net::UnixStream;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM, SIGTSTP};
use signal_hook::low_level::emulate_default_handler;

use crate::iceoryx::Clock;

/// The signals that have come.
pub(super) struct Signals {
    ends: Arc<AtomicBool>,
    stops: Arc<AtomicBool>,
    wakes: UnixStream,
}

impl Signals {
    /// Hears signals from now on. Under the virtual clock Ctrl-Z stops the launcher at once, because time stands still
    /// with it.
    ///
    /// # Errors
    /// The system does not take the handlers.
    pub fn hear(clock: Clock) -> io::Result<Signals> {
        let (ends, stops) = (Arc::new(AtomicBool::new(false)), Arc::new(AtomicBool::new(false)));
        let (wakes, waker) = UnixStream::pair()?;
        wakes.set_nonblocking(true)?;
        for signal in [SIGINT, SIGTERM, SIGHUP] {
            // The shutdown is registered before the flag is set: the first signal finds the flag clear, the second one
            // finds it set.
            signal_hook::flag::register_conditional_shutdown(signal, 130, Arc::clone(&ends))?;
            signal_hook::flag::register(signal, Arc::clone(&ends))?;
            signal_hook::low_level::pipe::register(signal, waker.try_clone()?)?;
        }
        if clock == Clock::Real {
            signal_hook::flag::register(SIGTSTP, Arc::clone(&stops))?;
            signal_hook::low_level::pipe::register(SIGTSTP, waker)?;
        }
        write_in_the_background();
        Ok(Signals { ends, stops, wakes })
    }

    /// Whether the launcher is to end. It stays so.
    pub fn ends(&self) -> bool {
        self.ends.load(Ordering::Acquire)
    }

    /// The flag behind [`ends`](Signals::ends).
    pub fn ends_flag(&self) -> Arc<AtomicBool> {
        Arc::clone(&self.ends)
    }

    /// Whether the launcher is to stop, once for each time that it was asked to.
    pub fn take_stop(&self) -> bool {
        self.stops.swap(false, Ordering::AcqRel)
    }

    /// Makes the descriptor unreadable until the next signal comes.
    pub fn clear(&self) {
        drop((&self.wakes).read(&mut [0; 64]));
    }

    /// The file descriptor that becomes readable when a signal has come.
    pub fn descriptor(&self) -> BorrowedFd<'_> {
        self.wakes.as_fd()
    }
}

/// Stops this process, as Ctrl-Z does, until it is continued.
pub(super) fn stop_until_continued() {
    // It fails for signals that do not exist.
    drop(emulate_default_handler(SIGTSTP));
}

/// Lets this process, and those that it starts, write to their terminal in the background as well, where `stty tostop`
/// would stop them.
fn write_in_the_background() {
    // SAFETY: ignoring a signal runs no code when it comes.
    #[allow(unsafe_code)]
    let _ = unsafe { libc::signal(libc::SIGTTOU, libc::SIG_IGN) };
}
