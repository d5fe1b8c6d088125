//! A wake-up futex: a word in shared memory that counts the wake-ups of a process, which sleeps on it.
//!
//! In: wake-ups by other processes, and by threads of this process. Out: a sleep until the next wake-up, or until a
//! time. A wake-up makes a system call only if the process sleeps. The event service of iceoryx2 is a socket and takes
//! four system calls for each message: see docs/decisions/0011-processes-and-shared-memory.md.

use core::num::NonZeroU32;
use core::sync::atomic::{AtomicU32, Ordering};
use std::fs::{File, OpenOptions};
use std::io;
use std::os::fd::AsFd;
use std::os::unix::fs::OpenOptionsExt;
use std::path::{Path, PathBuf};

use rustix::fs::{FallocateFlags, fallocate};
use rustix::mm::{MapFlags, ProtFlags, mmap};
use rustix::thread::futex;
use rustix::time::Timespec;

use mrroc_core::link::Nanos;

/// The folder of the futex's file: in memory, wherever the folder of the session is.
const FOLDER: &str = "/dev/shm";

/// Nanoseconds of a second.
pub(super) const NANOS: u64 = 1_000_000_000;

/// Size of the futex's file \[bytes\].
const SIZE: usize = size_of::<[AtomicU32; 2]>();

/// The wake-up futex of this process or of another process. It stays mapped as long as this process lives.
#[derive(Clone, Copy, Debug)]
pub(crate) struct WakeFutex {
    /// Number of wake-ups so far, wrapping.
    wakes: &'static AtomicU32,
    /// Whether the process sleeps.
    asleep: &'static AtomicU32,
}

impl WakeFutex {
    /// Makes the wake-up futex of the process at `place` of the session whose shared memory has this prefix.
    pub fn create(prefix: &str, place: usize) -> io::Result<WakeFutex> {
        let file = OpenOptions::new()
            .read(true)
            .write(true)
            .create_new(true)
            .mode(0o600)
            .open(path(prefix, place))?;
        // Its page is had now: where there is no room for it, the first wake-up would end the process.
        fallocate(&file, FallocateFlags::empty(), 0, SIZE as u64)?;
        WakeFutex::map(&file)
    }

    /// Opens the wake-up futex that another process has made.
    pub fn open(prefix: &str, place: usize) -> io::Result<WakeFutex> {
        let mut options = OpenOptions::new();
        let file = options.read(true).write(true).custom_flags(libc::O_NOFOLLOW).open(path(prefix, place))?;
        if file.metadata()?.len() != SIZE as u64 {
            return Err(io::Error::other("it is no wake-up futex"));
        }
        WakeFutex::map(&file)
    }

    /// Lets the process at `place` have the futex of the one at `first`: whoever sleeps on it sleeps for both.
    pub fn share(prefix: &str, first: usize, place: usize) -> io::Result<()> {
        std::fs::hard_link(path(prefix, first), path(prefix, place))
    }

    fn map(file: &File) -> io::Result<WakeFutex> {
        // SAFETY: a new mapping, which is never unmapped, of a file of that size, which no process makes shorter.
        #[allow(unsafe_code)]
        let memory = unsafe {
            let both = ProtFlags::READ | ProtFlags::WRITE;
            mmap(core::ptr::null_mut(), SIZE, both, MapFlags::SHARED | MapFlags::POPULATE, file.as_fd(), 0)?
        };
        // SAFETY: the mapping is aligned to a page, consists of atomics, for which every value is valid, and is never
        // unmapped.
        #[allow(unsafe_code)]
        let [wakes, asleep] = unsafe { &*memory.cast::<[AtomicU32; 2]>() };
        Ok(WakeFutex { wakes, asleep })
    }

    /// Wakes the process; if it is about to sleep, keeps it awake.
    pub fn wake(self) {
        // Both accesses are sequentially consistent: either the process sees the wake-up, or this call sees that it
        // sleeps.
        self.wakes.fetch_add(1, Ordering::SeqCst);
        if self.asleep.load(Ordering::SeqCst) != 0 {
            // The number of woken threads is not needed: if the process is gone, none is woken.
            let _ = futex::wake(self.wakes, futex::Flags::empty(), 1);
        }
    }

    /// Number of wake-ups so far.
    pub fn wakes(self) -> u32 {
        self.wakes.load(Ordering::SeqCst)
    }

    /// Sleeps until the number of wake-ups differs from `wakes`, or until a time of the machine's monotonic clock
    /// \[ns\]. It may return sooner.
    pub fn sleep(self, wakes: u32, until: Option<Nanos>) {
        self.asleep.store(1, Ordering::SeqCst);
        let until = until.map(timespec);
        // Woken, interrupted or timed out: the caller checks which.
        let _ = futex::wait_bitset(self.wakes, futex::Flags::empty(), wakes, until.as_ref(), NonZeroU32::MAX);
        self.asleep.store(0, Ordering::SeqCst);
    }
}

/// A time as the system takes it.
pub(super) fn timespec(nanos: Nanos) -> Timespec {
    Timespec { tv_sec: (nanos / NANOS).cast_signed(), tv_nsec: (nanos % NANOS).cast_signed() }
}

fn path(prefix: &str, place: usize) -> PathBuf {
    Path::new(FOLDER).join(format!("{prefix}wake{place}"))
}

#[cfg(test)]
mod tests {
    use super::super::monotonic;
    use super::*;

    /// A wake-up futex that is removed at the end of its test.
    struct Temporary(String, WakeFutex);

    impl Temporary {
        fn new(test: &str) -> Temporary {
            let prefix = format!("mrroc_test_{}_{test}_", std::process::id());
            let wake_futex = WakeFutex::create(&prefix, 3).expect("made");
            Temporary(prefix, wake_futex)
        }
    }

    impl Drop for Temporary {
        fn drop(&mut self) {
            let _ = std::fs::remove_file(path(&self.0, 3));
        }
    }

    #[test]
    fn whoever_was_rung_before_it_sleeps_does_not_sleep() {
        let Temporary(prefix, wake_futex) = &Temporary::new("before");
        let wakes = wake_futex.wakes();
        WakeFutex::open(prefix, 3).expect("there").wake();
        wake_futex.sleep(wakes, None);
        assert_eq!(wake_futex.wakes(), wakes + 1);
    }

    #[test]
    fn whoever_is_not_rung_sleeps_until_its_time() {
        let Temporary(_, wake_futex) = &Temporary::new("time");
        let until = monotonic() + 2_000_000;
        // A sleep may end sooner, so it is repeated until the time has come.
        while monotonic() < until {
            wake_futex.sleep(wake_futex.wakes(), Some(until));
        }
    }

    #[test]
    fn no_ring_is_lost_between_two_that_wake_each_other() {
        let (Temporary(_, ours), Temporary(_, theirs)) = (&Temporary::new("ours"), &Temporary::new("theirs"));
        let (ours, theirs) = (*ours, *theirs);
        let answers = std::thread::spawn(move || {
            for turn in 0..10_000 {
                while theirs.wakes() == turn {
                    theirs.sleep(turn, None);
                }
                ours.wake();
            }
        });
        for turn in 0..10_000 {
            theirs.wake();
            while ours.wakes() == turn {
                ours.sleep(turn, None);
            }
        }
        answers.join().expect("it ends");
    }

    #[test]
    fn a_bell_is_made_once_and_no_other_file_is_taken_for_one() {
        let Temporary(prefix, _) = &Temporary::new("once");
        assert!(WakeFutex::create(prefix, 3).is_err());
        assert!(WakeFutex::open(prefix, 4).is_err());
        std::fs::write(path(prefix, 3), [0; SIZE + 1]).expect("written");
        assert!(WakeFutex::open(prefix, 3).is_err());
    }
}
