//! The signals that a launcher hears from its terminal.
//!
//! In: Ctrl-C and its like, Ctrl-Z. Out: flags, and a descriptor that becomes readable when one of them is set. The first
//! Ctrl-C aborts, after which the cell closes, whatever its program does; the second one ends the launcher at once. Ctrl-Z
//! asks the launcher to suspend its cell and to stop. Where no cell runs, each of them does what it does to any program: one
//! that has to wait for a reader of its last words can be interrupted and stopped.

use std::io::{self, Read};
use std::os::fd::{AsFd, BorrowedFd};
use std::os::unix::net::UnixStream;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};

use signal_hook::SigId;
use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM, SIGTSTP};
use signal_hook::low_level::{emulate_default_handler, unregister};

use mrroc_core::link::Clock;

/// What ends a launcher: Ctrl-C, a request of the system, and the end of its terminal.
const ENDS: [i32; 3] = [SIGINT, SIGTERM, SIGHUP];

/// The signals that have come.
pub(crate) struct Signals {
    ends: Arc<AtomicBool>,
    stops: Arc<AtomicBool>,
    wakes: UnixStream,
    /// What is done when a signal comes.
    actions: Vec<SigId>,
}

/// Signals that a program has heard at some time, each with whether it does now what it does to any program. A handler
/// stays for ever, so without this a signal would do nothing between two cells.
static HEARD: Mutex<Vec<(i32, Arc<AtomicBool>)>> = Mutex::new(Vec::new());

/// Says whether a signal does what it does to any program.
fn set_default(signal: i32, is_default: bool) -> io::Result<()> {
    let mut heard = HEARD.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
    if let Some((_, default)) = heard.iter().find(|(known, _)| *known == signal) {
        default.store(is_default, Ordering::Release);
    } else if !is_default {
        let default = Arc::new(AtomicBool::new(false));
        signal_hook::flag::register_conditional_default(signal, Arc::clone(&default))?;
        heard.push((signal, default));
    }
    Ok(())
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
        // From here on what has been registered is taken back if the rest fails.
        let mut signals = Signals { ends, stops, wakes, actions: Vec::new() };
        let actions = &mut signals.actions;
        for signal in ENDS {
            // The shutdown is registered before the flag is set: the first signal finds the flag clear, the second one
            // finds it set.
            let ends = || Arc::clone(&signals.ends);
            actions.push(signal_hook::flag::register_conditional_shutdown(signal, 130, ends())?);
            actions.push(signal_hook::flag::register(signal, ends())?);
            actions.push(signal_hook::low_level::pipe::register(signal, waker.try_clone()?)?);
            set_default(signal, false)?;
        }
        if clock == Clock::Real {
            actions.push(signal_hook::flag::register(SIGTSTP, Arc::clone(&signals.stops))?);
            actions.push(signal_hook::low_level::pipe::register(SIGTSTP, waker)?);
            set_default(SIGTSTP, false)?;
        }
        write_in_the_background();
        Ok(signals)
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

impl Drop for Signals {
    fn drop(&mut self) {
        for signal in ENDS.into_iter().chain([SIGTSTP]) {
            // What is registered already cannot fail.
            let _ = set_default(signal, true);
        }
        // One that has come when the cell was over already. One that comes from here on stops the launcher by itself.
        if self.take_stop() {
            stop_until_continued();
        }
        self.actions.drain(..).for_each(|action| _ = unregister(action));
    }
}

/// Stops this process, as Ctrl-Z does, until it is continued.
pub(crate) fn stop_until_continued() {
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
