//! What a machine must be able to give before a cell's processes start: shared memory and open files (row 35 of SAFETY.md).
//!
//! In: how many ways between processes there are. Out: nothing, or what is too little and what to change. A process that
//! finds shared memory full when it first writes there is killed, and so is one that cannot open what it needs too late to
//! say why in words of the user's.

use std::io;
use std::path::Path;

use rustix::fs::statvfs;
use rustix::process::{Resource, Rlimit, getrlimit, setrlimit};

use super::session::SHARED_MEMORY;

/// Shared memory of a process or of a way between two \[bytes\]. The cell of the tests takes 30 kB for each.
const SHARED_EACH: u64 = 128 << 10;

/// Files that a process has open, and those that each process and each way adds to it. The busiest process of the cell of
/// the tests, with 10 processes and 15 ways, has 67.
const FILES: u64 = 40;
const FILES_EACH: u64 = 4;

/// The machine has too little of something.
#[derive(Debug, thiserror::Error)]
pub(crate) enum NoRoom {
    /// Shared memory.
    #[error(
        "{SHARED_MEMORY} has {} kB free, the cell needs {}\n help: remove what is not needed there, or mount it larger; \
         in a container: --shm-size=64m",
        free >> 10,
        needed >> 10
    )]
    Shared {
        /// What there is and what is needed \[bytes\].
        free: u64,
        needed: u64,
    },
    /// Open files.
    #[error("a process may open {allowed} files, one of this cell needs {needed}\n help: ulimit -n {needed}")]
    Files {
        /// What is allowed at most, and what is needed.
        allowed: u64,
        needed: u64,
    },
    /// It cannot be told.
    #[error("{SHARED_MEMORY} cannot be looked at: {0}")]
    Unknown(io::Error),
}

/// Bytes that are free in shared memory.
pub(super) fn free_shared_memory() -> io::Result<u64> {
    let shm = statvfs(Path::new(SHARED_MEMORY))?;
    Ok(shm.f_bavail * shm.f_frsize)
}

/// Looks whether there is room for so many processes and ways between them. The limit of open files is raised to
/// that, where this process may, for itself and for those that it starts.
///
/// # Errors
/// [`NoRoom`]
pub(super) fn check(processes_and_ways: usize) -> Result<(), NoRoom> {
    let count = processes_and_ways as u64;
    let needed = FILES + FILES_EACH * count;
    let Rlimit { current, maximum } = getrlimit(Resource::Nofile);
    let is_too_low = current.is_some_and(|current| current < needed);
    if is_too_low && setrlimit(Resource::Nofile, Rlimit { current: Some(needed), maximum }).is_err() {
        return Err(NoRoom::Files { allowed: maximum.unwrap_or(u64::MAX), needed });
    }
    let (free, needed) = (free_shared_memory().map_err(NoRoom::Unknown)?, SHARED_EACH * count);
    if free < needed { Err(NoRoom::Shared { free, needed }) } else { Ok(()) }
}
