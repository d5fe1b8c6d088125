//! A bell: a word in shared memory that whoever has something for a process counts up, and the process sleeps on.
//!
//! In: rings of other processes, and of threads of the own one. Out: a sleep until the next ring, or until a time. A ring
//! calls the system only where somebody sleeps. The event service of iceoryx2 is a socket and takes four calls for each
//! message: see docs/decisions/0014-bells-are-futexes.md.

use core::num::NonZeroU32;
use core::sync::atomic::{AtomicU32, Ordering};
use std::fs::{File, OpenOptions};
use std::io;
use std::os::fd::AsFd;
use std::os::unix::fs::OpenOptionsExt;
use std::path::{Path, PathBuf};

use rustix::mm::{MapFlags, ProtFlags, mmap};
use rustix::thread::futex;

use super::waiter::timespec;
use mrroc_core::link::Nanos;

/// Where its file lies: in memory, whatever the folder of the session is.
const FOLDER: &str = "/dev/shm";

/// Bytes of its file.
const SIZE: usize = size_of::<[AtomicU32; 2]>();

/// A process's bell, or the rope of another one's. It stays mapped for as long as the process lives.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bell {
    /// Rings so far, wrapping.
    rings: &'static AtomicU32,
    /// Whether the process sleeps.
    asleep: &'static AtomicU32,
}

impl Bell {
    /// Makes the bell of the process at `place` of the session whose shared memory has this prefix.
    pub fn create(prefix: &str, place: usize) -> io::Result<Bell> {
        let file = OpenOptions::new()
            .read(true)
            .write(true)
            .create_new(true)
            .mode(0o600)
            .open(path(prefix, place))?;
        file.set_len(SIZE as u64)?;
        Bell::map(&file)
    }

    /// Takes the rope of a bell that there is.
    pub fn open(prefix: &str, place: usize) -> io::Result<Bell> {
        let file = OpenOptions::new().read(true).write(true).open(path(prefix, place))?;
        if file.metadata()?.len() != SIZE as u64 {
            return Err(io::Error::other("it is no bell"));
        }
        Bell::map(&file)
    }

    fn map(file: &File) -> io::Result<Bell> {
        // SAFETY: a new mapping, which is never unmapped, of a file of that size; nobody makes it shorter.
        #[allow(unsafe_code)]
        let memory = unsafe {
            let both = ProtFlags::READ | ProtFlags::WRITE;
            mmap(core::ptr::null_mut(), SIZE, both, MapFlags::SHARED | MapFlags::POPULATE, file.as_fd(), 0)?
        };
        // SAFETY: a mapping begins with a page; all of it is atomics, for which every value is one; and it stays.
        #[allow(unsafe_code)]
        let [rings, asleep] = unsafe { &*memory.cast::<[AtomicU32; 2]>() };
        Ok(Bell { rings, asleep })
    }

    /// Wakes the process, or keeps it from falling asleep.
    pub fn ring(self) {
        // In one order for all: either the process sees the ring, or this sees that it sleeps.
        self.rings.fetch_add(1, Ordering::SeqCst);
        if self.asleep.load(Ordering::SeqCst) != 0 {
            // The number of those woken says nothing more: a process that is gone is not woken.
            let _ = futex::wake(self.rings, futex::Flags::empty(), 1);
        }
    }

    /// Rings so far.
    pub fn rings(self) -> u32 {
        self.rings.load(Ordering::SeqCst)
    }

    /// Sleeps until there are not just so many rings, or until a time of the machine's monotonic clock; it may end sooner.
    pub fn sleep(self, rings: u32, until: Option<Nanos>) {
        self.asleep.store(1, Ordering::SeqCst);
        let until = until.map(timespec);
        // Rung meanwhile, interrupted or over: whoever sleeps looks.
        let _ = futex::wait_bitset(self.rings, futex::Flags::empty(), rings, until.as_ref(), NonZeroU32::MAX);
        self.asleep.store(0, Ordering::SeqCst);
    }
}

fn path(prefix: &str, place: usize) -> PathBuf {
    Path::new(FOLDER).join(format!("{prefix}bell{place}"))
}

#[cfg(test)]
mod tests {
    use super::super::monotonic;
    use super::*;

    /// A bell that ends with its test.
    struct Hung(String, Bell);

    impl Hung {
        fn new(test: &str) -> Hung {
            let prefix = format!("mrroc_test_{}_{test}_", std::process::id());
            let bell = Bell::create(&prefix, 3).expect("made");
            Hung(prefix, bell)
        }
    }

    impl Drop for Hung {
        fn drop(&mut self) {
            let _ = std::fs::remove_file(path(&self.0, 3));
        }
    }

    #[test]
    fn whoever_was_rung_before_it_sleeps_does_not_sleep() {
        let Hung(prefix, bell) = &Hung::new("before");
        let rings = bell.rings();
        Bell::open(prefix, 3).expect("there").ring();
        bell.sleep(rings, None);
        assert_eq!(bell.rings(), rings + 1);
    }

    #[test]
    fn whoever_is_not_rung_sleeps_until_its_time() {
        let Hung(_, bell) = &Hung::new("time");
        let until = monotonic() + 2_000_000;
        // It may wake sooner, but not for ever.
        while monotonic() < until {
            bell.sleep(bell.rings(), Some(until));
        }
    }

    #[test]
    fn no_ring_is_lost_between_two_that_wake_each_other() {
        let (Hung(_, ours), Hung(_, theirs)) = (&Hung::new("ours"), &Hung::new("theirs"));
        let (ours, theirs) = (*ours, *theirs);
        let answers = std::thread::spawn(move || {
            for turn in 0..10_000 {
                while theirs.rings() == turn {
                    theirs.sleep(turn, None);
                }
                ours.ring();
            }
        });
        for turn in 0..10_000 {
            theirs.ring();
            while ours.rings() == turn {
                ours.sleep(turn, None);
            }
        }
        answers.join().expect("it ends");
    }

    #[test]
    fn a_bell_is_made_once_and_no_other_file_is_taken_for_one() {
        let Hung(prefix, _) = &Hung::new("once");
        assert!(Bell::create(prefix, 3).is_err());
        assert!(Bell::open(prefix, 4).is_err());
        std::fs::write(path(prefix, 3), [0; SIZE + 1]).expect("written");
        assert!(Bell::open(prefix, 3).is_err());
    }
}
