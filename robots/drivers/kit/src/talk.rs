//! Work that blocks while a device answers, in a thread of its own: for a protocol that is no [`Protocol`](crate::Protocol) yet.
//!
//! In: what both sides hand to each other, in atomics, so that neither waits for the other. Out: whether the work goes on, and why it has
//! ended.

use std::io;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, OnceLock};
use std::thread::JoinHandle;

/// What the thread and who started it hand to each other.
pub trait Handed: Send + Sync + 'static {
    /// Wakes a thread that waits for the device, because it is to end. One that never waits for long needs nothing.
    fn hang_up(&self) {}
}

/// Whether the thread is to end.
#[derive(Debug)]
pub struct Watch(AtomicBool);

impl Watch {
    /// Whether it is to end.
    #[must_use]
    pub fn ends(&self) -> bool {
        self.0.load(Ordering::Acquire)
    }
}

/// What both sides see.
#[derive(Debug)]
struct Shared<H, E> {
    handed: H,
    watch: Watch,
    /// Why it has ended.
    over: OnceLock<E>,
}

/// A talk with a device that goes on in a thread of its own, and ends when this is dropped.
///
/// ```
/// use mrroc_driver_kit::{Handed, Number, Talk, Watch};
///
/// #[derive(Default)]
/// struct Level(Number);
/// impl Handed for Level {}
///
/// let work = |level: &Level, _: &Watch| {
///     level.0.set(0.5);
///     Err("the device has hung up")
/// };
/// let talk = Talk::begin("tank", Level::default(), "closed", work)?;
/// while talk.goes_on().is_ok() {
///     std::thread::yield_now();
/// }
/// assert_eq!(talk.goes_on(), Err("the device has hung up"));
/// assert_eq!(talk.handed().0.get(), 0.5);
/// # Ok::<(), std::io::Error>(())
/// ```
#[derive(Debug)]
pub struct Talk<H: Handed, E> {
    shared: Arc<Shared<H, E>>,
    closed: E,
    thread: Option<JoinHandle<()>>,
}

impl<H: Handed, E: Copy + Send + Sync + 'static> Talk<H, E> {
    /// Begins a thread of this name, and returns. `closed` is why it has ended where nothing went wrong.
    ///
    /// # Errors
    /// A thread cannot be started.
    pub fn begin(
        name: &str,
        handed: H,
        closed: E,
        work: impl FnOnce(&H, &Watch) -> Result<(), E> + Send + 'static,
    ) -> io::Result<Talk<H, E>> {
        let shared = Arc::new(Shared { handed, watch: Watch(AtomicBool::new(false)), over: OnceLock::new() });
        let of_thread = Arc::clone(&shared);
        let thread = std::thread::Builder::new().name(name.to_owned()).spawn(move || {
            let outcome = work(&of_thread.handed, &of_thread.watch);
            // It is told before anybody sees that the thread has ended.
            let _ = of_thread.over.set(outcome.err().unwrap_or(closed));
        })?;
        Ok(Talk { shared, closed, thread: Some(thread) })
    }

    /// Whether it goes on.
    ///
    /// # Errors
    /// Why it does not.
    pub fn goes_on(&self) -> Result<(), E> {
        let over = self.shared.over.get().copied();
        // A thread that panicked has told nothing.
        over.or_else(|| self.is_over().then_some(self.closed)).map_or(Ok(()), Err)
    }
}

impl<H: Handed, E> Talk<H, E> {
    /// What the two sides hand to each other.
    #[must_use]
    pub fn handed(&self) -> &H {
        &self.shared.handed
    }

    /// Ends it.
    pub fn hang_up(&self) {
        self.shared.watch.0.store(true, Ordering::Release);
        self.shared.handed.hang_up();
    }

    /// Whether its thread has ended.
    #[must_use]
    pub fn is_over(&self) -> bool {
        self.thread.as_ref().is_none_or(JoinHandle::is_finished)
    }
}

impl<H: Handed, E> Drop for Talk<H, E> {
    fn drop(&mut self) {
        self.hang_up();
        // A thread that panicked has nothing left to end.
        let _ = self.thread.take().map(JoinHandle::join);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Waits as a thread in a system call does, until it is woken.
    #[derive(Default)]
    struct Waiting(std::sync::Mutex<bool>, std::sync::Condvar);

    impl Handed for Waiting {
        fn hang_up(&self) {
            *self.0.lock().expect("whole") = true;
            self.1.notify_all();
        }
    }

    #[test]
    fn a_talk_ends_when_it_is_hung_up_and_wakes_its_thread() {
        let work = |waiting: &Waiting, watch: &Watch| {
            let woken = waiting.0.lock().expect("whole");
            drop(waiting.1.wait_while(woken, |woken| !*woken).expect("whole"));
            assert!(watch.ends());
            Ok(())
        };
        let talk = Talk::begin("waiting", Waiting::default(), "closed", work).expect("a thread");
        assert_eq!(talk.goes_on(), Ok(()));
        talk.hang_up();
        while !talk.is_over() {
            std::thread::yield_now();
        }
        assert_eq!(talk.goes_on(), Err("closed"));
        // Dropping one whose thread waits returns as well.
        drop(Talk::begin("waiting", Waiting::default(), "closed", work).expect("a thread"));
    }

    #[test]
    fn a_thread_that_panics_has_ended() {
        let work = |_: &Waiting, _: &Watch| panic!("as it should");
        let talk = Talk::begin("panics", Waiting::default(), "closed", work).expect("a thread");
        while talk.goes_on().is_ok() {
            std::thread::yield_now();
        }
        assert_eq!(talk.goes_on(), Err("closed"));
    }
}
