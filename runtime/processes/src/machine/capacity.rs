//! Whether a machine has enough shared memory and open files for a cell's processes (fault 35 in docs/safety).
//!
//! In: the number of processes and of connections between them. Out: nothing if there is enough, or what is too little and
//! what to change. The check comes before the processes start, because later errors are hard to understand: a process
//! that first writes to shared memory when it is full is killed, and one that cannot open a file fails without naming
//! the cause.

use std::io;
use std::path::Path;

use rustix::fs::statvfs;
use rustix::process::{Resource, Rlimit, getrlimit, setrlimit};

/// The folder of the segments of shared memory.
pub(crate) const SHARED_MEMORY: &str = "/dev/shm";

/// Shared memory of a process, or of a connection between two processes \[bytes\]. The cell of the tests takes 30 kB for each.
const SHARED_EACH: u64 = 128 << 10;

/// Files that a process has open by itself, and those that each process and each connection of the cell adds. In the cell of
/// the tests, with 10 processes and 15 connections, the process with the most has 67.
const FILES: u64 = 40;
const FILES_EACH: u64 = 4;

/// Why a machine has no room for a cell.
#[derive(Debug, thiserror::Error)]
pub(crate) enum NoRoom {
    /// There is too little shared memory.
    #[error(
        "{SHARED_MEMORY} has {} kB free, the cell needs {}\n help: remove what is not needed there, or mount it larger; \
         in a container: --shm-size=64m",
        free >> 10,
        needed >> 10
    )]
    Shared {
        /// Free and needed shared memory \[bytes\].
        free: u64,
        needed: u64,
    },
    /// A process may open too few files.
    #[error("a process may open {allowed} files, one of this cell needs {needed}\n help: ulimit -n {needed}")]
    Files {
        /// The allowed and the needed number of open files.
        allowed: u64,
        needed: u64,
    },
    /// The machine could not be asked.
    #[error("{SHARED_MEMORY} cannot be looked at: {0}")]
    Unknown(io::Error),
}

/// What to do about an error of the system when it means that the machine has no more of something; empty for any other.
pub(crate) fn remedy(error: &io::Error) -> &'static str {
    match error.kind() {
        io::ErrorKind::StorageFull => {
            "\n help: there is no room left, or no inode: make room (df, df -i), or set XDG_RUNTIME_DIR to a folder elsewhere"
        }
        io::ErrorKind::QuotaExceeded => {
            "\n help: you may not store more there: remove what you do not need, or set XDG_RUNTIME_DIR to a folder elsewhere"
        }
        io::ErrorKind::WouldBlock | io::ErrorKind::OutOfMemory => {
            "\n help: there is no room for another process or thread: end some, or allow this user more: ulimit -u"
        }
        _ => "",
    }
}

/// Free shared memory \[bytes\].
pub(crate) fn free_shared_memory() -> io::Result<u64> {
    let shm = statvfs(Path::new(SHARED_MEMORY))?;
    Ok(shm.f_bavail * shm.f_frsize)
}

/// Checks that there is room for so many processes and connections between them. If so many files are allowed, so many consoles may
/// connect to the cell. Raises the limit of open files of this
/// process, and so of the processes that it starts, to what they need, as far as the system allows it.
///
/// # Errors
/// [`NoRoom`]
pub(crate) fn check(processes_and_connections: usize, consoles: usize) -> Result<(), NoRoom> {
    let count = processes_and_connections as u64;
    let needed = FILES + FILES_EACH * count;
    let Rlimit { current, maximum } = getrlimit(Resource::Nofile);
    if maximum.is_some_and(|maximum| maximum < needed) {
        return Err(NoRoom::Files { allowed: maximum.unwrap_or(u64::MAX), needed });
    }
    let wanted = (needed + consoles as u64).min(maximum.unwrap_or(u64::MAX));
    let is_below = |limit| current.is_some_and(|current| current < limit);
    let raise = || setrlimit(Resource::Nofile, Rlimit { current: Some(wanted), maximum });
    if is_below(wanted) && raise().is_err() && is_below(needed) {
        return Err(NoRoom::Files { allowed: current.unwrap_or(u64::MAX), needed });
    }
    let (free, needed) = (free_shared_memory().map_err(NoRoom::Unknown)?, SHARED_EACH * count);
    if free < needed { Err(NoRoom::Shared { free, needed }) } else { Ok(()) }
}
