//! The state board of a session: shared memory in which each process shows what it does.
//!
//! In: numbers that each process writes into its own entry in every step, and the launcher's heartbeat. Out: the newest
//! numbers, read by the launcher, the heartbeat, read by the MP, and the stops that consoles ask for, read by the MP and all EDPs. Writing takes a few stores and never waits: a sequence number that is odd while the numbers change tells a
//! reader to read again (a sequence lock). A reader that finds them changing each time it tries gets nothing.

use std::fs::{self, File, OpenOptions};
use std::io;
use std::os::fd::AsFd;
use std::os::unix::fs::OpenOptionsExt;
use std::path::PathBuf;
use std::ptr::NonNull;
use std::sync::atomic::{AtomicU64, Ordering, fence};

use rustix::fs::{FallocateFlags, fallocate};
use rustix::mm::{MapFlags, ProtFlags, mmap, munmap};

use super::heartbeat::Heartbeat;
use crate::machine::capacity::SHARED_MEMORY;
use crate::session::prefix;
use std::sync::atomic::AtomicI64;

/// Words of an entry, its sequence number not counted.
pub(super) const ENTRY: usize = 159;

/// How many times a reader tries before it gives up.
const LOOKS: usize = 1000;

/// The numbers of one process.
#[repr(C)]
struct Entry {
    sequence: AtomicU64,
    words: [AtomicU64; ENTRY],
}

impl Entry {
    fn write(&self, from: usize, words: &[u64]) {
        let sequence = self.sequence.load(Ordering::Relaxed);
        self.sequence.store(sequence.wrapping_add(1), Ordering::Relaxed);
        fence(Ordering::Release);
        for (place, word) in self.words.iter().skip(from).zip(words) {
            place.store(*word, Ordering::Relaxed);
        }
        self.sequence.store(sequence.wrapping_add(2), Ordering::Release);
    }

    fn read(&self) -> Option<[u64; ENTRY]> {
        (0..LOOKS).find_map(|_| {
            let before = self.sequence.load(Ordering::Acquire);
            let words = core::array::from_fn(|i| self.words[i].load(Ordering::Relaxed));
            fence(Ordering::Acquire);
            let after = self.sequence.load(Ordering::Relaxed);
            // 0: the entry was never written.
            (before == after && before.is_multiple_of(2) && before > 0).then_some(words)
        })
    }
}

/// The entries of all processes of a session, by their places.
#[derive(Debug)]
pub(crate) struct StateBoard {
    panels: NonNull<Entry>,
    count: usize,
}

// SAFETY: entries and heartbeat are atomics in memory that is mapped until the board is dropped.
#[allow(unsafe_code)]
unsafe impl Send for StateBoard {}

impl StateBoard {
    /// Makes the board of a session with `count` processes.
    ///
    /// # Errors
    /// There is too little shared memory for the board.
    pub fn create(session: u64, count: usize) -> io::Result<StateBoard> {
        let file =
            OpenOptions::new().read(true).write(true).create_new(true).mode(0o600).open(path(session))?;
        // All of the file is allocated before any robot moves: otherwise full shared memory would end a process that
        // writes.
        fallocate(&file, FallocateFlags::empty(), 0, bytes(count) as u64)?;
        StateBoard::map(&file, count)
    }

    /// Opens the board of a session, however many processes it has.
    ///
    /// # Errors
    /// There is none.
    pub fn of(session: u64) -> io::Result<StateBoard> {
        let length = fs::metadata(path(session))?.len() as usize;
        StateBoard::open(session, length.saturating_sub(bytes(0)) / size_of::<Entry>())
    }

    /// Opens the board that the session's launcher made.
    ///
    /// # Errors
    /// The board does not exist, or has another size.
    pub fn open(session: u64, count: usize) -> io::Result<StateBoard> {
        let mut options = OpenOptions::new();
        let file = options.read(true).write(true).custom_flags(libc::O_NOFOLLOW).open(path(session))?;
        if file.metadata()?.len() != bytes(count) as u64 {
            return Err(io::Error::new(io::ErrorKind::InvalidData, "a state board of another cell"));
        }
        StateBoard::map(&file, count)
    }

    fn map(file: &File, count: usize) -> io::Result<StateBoard> {
        let (access, flags) = (ProtFlags::READ | ProtFlags::WRITE, MapFlags::SHARED | MapFlags::POPULATE);
        // SAFETY: a new mapping at an address that the system chooses, where nothing else is mapped.
        #[allow(unsafe_code)]
        let mapped = unsafe { mmap(core::ptr::null_mut(), bytes(count), access, flags, file.as_fd(), 0) }?;
        let panels = NonNull::new(mapped.cast()).ok_or(io::ErrorKind::OutOfMemory)?;
        Ok(StateBoard { panels, count })
    }

    fn entry(&self, place: usize) -> Option<&Entry> {
        // SAFETY: the mapping holds `count` entries, aligned to a page; every byte of them is part of an atomic number;
        // and the mapping lives as long as the board.
        #[allow(unsafe_code)]
        (place < self.count).then(|| unsafe { self.panels.add(place).as_ref() })
    }

    /// The launcher's heartbeat.
    pub fn heartbeat(&self) -> &Heartbeat {
        // SAFETY: the mapping holds the heartbeat, an atomic number, after its entries, and lives as long as the board; the
        // size of an entry is a multiple of 8, so the number is aligned.
        #[allow(unsafe_code)]
        unsafe {
            self.panels.add(self.count).cast::<Heartbeat>().as_ref()
        }
    }

    /// By how much the cell's time has moved on this machine since it began \[ns\]: always 0 but on a node that follows another one.
    pub fn slew(&self) -> &AtomicI64 {
        // SAFETY: as of the heartbeat, behind which it lies.
        #[allow(unsafe_code)]
        unsafe {
            self.panels.add(self.count).cast::<Heartbeat>().add(1).cast::<AtomicI64>().as_ref()
        }
    }

    /// How many stops consoles have asked for.
    pub fn stops_asked(&self) -> &AtomicU64 {
        self.stops(0)
    }

    /// How many of them the MP has begun to carry out.
    pub fn stops_begun(&self) -> &AtomicU64 {
        self.stops(1)
    }

    /// In which step it began the last of them; `u64::MAX`: the cell was in the fault state already.
    pub fn stop_step(&self) -> &AtomicU64 {
        self.stops(2)
    }

    fn stops(&self, nth: usize) -> &AtomicU64 {
        // SAFETY: as of the heartbeat, behind which and the slew they lie; `nth` is less than 3.
        #[allow(unsafe_code)]
        unsafe {
            self.panels.add(self.count).cast::<Heartbeat>().add(2).cast::<AtomicU64>().add(nth).as_ref()
        }
    }

    /// Shows the numbers of the process at a place; only that process may call this. Words beyond the entry's size are
    /// left out.
    pub fn write(&self, place: usize, words: &[u64]) {
        self.write_from(place, 0, words);
    }

    /// The same from the word at `from` on: what stands elsewhere in the entry stays as it is.
    pub fn write_from(&self, place: usize, from: usize, words: &[u64]) {
        if let Some(entry) = self.entry(place) {
            entry.write(from, words);
        }
    }

    /// The numbers shown last by the process at a place; `None` before it has shown any, or if it died while it wrote
    /// them.
    pub fn read(&self, place: usize) -> Option<[u64; ENTRY]> {
        self.entry(place)?.read()
    }
}

impl Drop for StateBoard {
    fn drop(&mut self) {
        // SAFETY: `map` made this mapping, it is unmapped once, and no entry is borrowed any more.
        #[allow(unsafe_code)]
        let _ = unsafe { munmap(self.panels.as_ptr().cast(), bytes(self.count)) };
    }
}

fn bytes(count: usize) -> usize {
    count * size_of::<Entry>() + size_of::<Heartbeat>() + size_of::<AtomicI64>() + 3 * size_of::<AtomicU64>()
}

fn path(session: u64) -> PathBuf {
    PathBuf::from(SHARED_MEMORY).join(format!("{}state", prefix(session)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::AtomicBool;

    /// A board of this test, whose file is removed with it.
    struct Board(StateBoard, u64);

    impl Board {
        fn new(test: u64) -> Board {
            // A bit above those of a session's number, so that it is no session's number.
            let session = 1 << 60 | u64::from(std::process::id()) << 8 | test;
            Board(StateBoard::create(session, 2).expect("shared memory"), session)
        }
    }

    impl Drop for Board {
        fn drop(&mut self) {
            let _ = std::fs::remove_file(path(self.1));
        }
    }

    #[test]
    fn what_one_process_shows_another_one_reads_and_no_more() {
        let board = Board::new(1);
        let other = StateBoard::open(board.1, 2).expect("a board");
        assert_eq!(other.read(0), None);
        board.0.write(0, &[1, 2, 3]);
        assert_eq!(other.read(0).expect("shown")[..4], [1, 2, 3, 0]);
        assert_eq!((other.read(1), other.read(2)), (None, None));
        board.0.write(2, &[1]);
        assert!(StateBoard::open(board.1, 3).is_err());
    }

    #[test]
    fn numbers_that_change_while_they_are_read_are_never_mixed() {
        let board = Board::new(2);
        let open = || StateBoard::open(board.1, 2).expect("a board");
        let (writer, reader) = (open(), open());
        writer.write(1, &[0; ENTRY]);
        let over = &AtomicBool::new(false);
        std::thread::scope(|scope| {
            scope.spawn(move || {
                (1..100_000).for_each(|number| writer.write(1, &[number; ENTRY]));
                over.store(true, Ordering::Release);
            });
            scope.spawn(move || {
                let mut last = 0;
                while !over.load(Ordering::Acquire) {
                    if let Some(words) = reader.read(1) {
                        assert!(words.iter().all(|&word| word == words[0]), "{words:?}");
                        assert!(words[0] >= last);
                        last = words[0];
                    }
                }
            });
        });
    }
}
