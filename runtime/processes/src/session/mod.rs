//! A session: the files and the shared memory of one launch, kept apart from those of any other launch, running or
//! crashed.
//!
//! In: the path of a cell's file. Out: a session of its own, after the remains of crashed sessions are removed.
//!
//! A folder that belongs to one user (mode 0700) contains the lock of every running cell, with the number of its
//! launcher's process, and one folder per session. That folder is the root path of the session's shared memory, and the
//! names of its segments begin with a prefix of the session. Every process of a session holds the session's lock,
//! shared: if the lock is free, the session is over or has crashed, and the next launch removes its remains.

mod error;
mod lock;

use std::fs::{self, DirBuilder, DirEntry, File, OpenOptions};
use std::hash::{BuildHasher, Hasher, RandomState};
use std::io;
use std::os::unix::fs::{DirBuilderExt, MetadataExt, OpenOptionsExt};
use std::path::{Path, PathBuf};

use rustix::fs::Mode;
use rustix::process::umask;

pub(crate) use error::SessionError;
pub(super) use lock::CellLock;

use crate::machine::capacity::SHARED_MEMORY;
use crate::machine::identity::CellId;

/// The longest root path \[bytes\]: the path of a socket in it is 57 bytes longer, and the system allows 107.
const MAX_ROOT: usize = 50;

/// Bits of a session's number: few, because its digits are part of the path of each socket, whose length is limited.
const NUMBER_BITS: u32 = 48;

fn at(path: &Path) -> impl FnOnce(io::Error) -> SessionError {
    let path = path.to_owned();
    move |error| SessionError::Io(path, error)
}

/// As long as it lives, all that this process makes is its user's alone, whatever mode is asked for: umask 077.
#[derive(Debug)]
pub(super) struct Private(Mode);

impl Private {
    /// Begins.
    pub fn begin() -> Private {
        Private(umask(Mode::RWXG | Mode::RWXO))
    }
}

impl Drop for Private {
    fn drop(&mut self) {
        umask(self.0);
    }
}

/// The files of one launch.
#[derive(Debug)]
pub(super) struct Session {
    folder: PathBuf,
    number: u64,
    cell: CellId,
    _lock: File,
}

impl Session {
    fn make(base: &Path, cell: u32, id: CellId) -> Result<Session, SessionError> {
        let _private = Private::begin();
        // Nobody can know the number before: the seeds of hash tables come from the system's random numbers, so they serve as a random session number.
        let number = RandomState::new().build_hasher().finish() >> (u64::BITS - NUMBER_BITS);
        let folder = base.join(format!("{cell:08x}-{number:012x}"));
        if folder.as_os_str().len() > MAX_ROOT {
            return Err(SessionError::TooLong(base.to_owned()));
        }
        DirBuilder::new().mode(0o700).create(&folder).map_err(at(&folder))?;
        let path = folder.join("lock");
        let lock = open(&path).and_then(|lock| lock.lock_shared().map(|()| lock)).map_err(at(&path))?;
        Ok(Session { folder, number, cell: id, _lock: lock })
    }

    /// The folder of the session, which is the root path of its shared memory.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// What its cell is to the machine.
    pub const fn cell(&self) -> CellId {
        self.cell
    }

    /// The number of the session, which every message carries.
    pub const fn number(&self) -> u64 {
        self.number
    }

    /// Looks for files with names of the session's shared memory that its processes have not made: why a launch failed.
    ///
    /// # Errors
    /// [`SessionError::Foreign`]: one of them.
    pub fn check_names(&self) -> Result<(), SessionError> {
        let user = rustix::process::geteuid().as_raw();
        for segment in segments(self.number) {
            // What is gone by now was the session's own.
            let Ok(about) = fs::symlink_metadata(&segment) else { continue };
            if !about.is_file() || about.uid() != user {
                return Err(SessionError::Foreign(segment, about.uid()));
            }
        }
        Ok(())
    }
}

impl Drop for Session {
    fn drop(&mut self) {
        remove(&self.folder, self.number);
    }
}

/// The membership of a process in a session that its launcher made.
#[derive(Debug)]
pub(super) struct Membership {
    pub number: u64,
    _lock: File,
}

impl Membership {
    /// Joins the session in a folder.
    pub fn join(folder: &Path) -> Result<Membership, SessionError> {
        let name = folder.file_name().and_then(|name| name.to_str()).and_then(read_name);
        let foreign = || io::Error::other("no session of this program");
        let (_, number) = name.ok_or_else(foreign).map_err(at(folder))?;
        let path = folder.join("lock");
        let lock = File::open(&path).and_then(|lock| lock.lock_shared().map(|()| lock)).map_err(at(&path))?;
        Ok(Membership { number, _lock: lock })
    }
}

/// The number of the cell in a file, by which its sessions are found.
fn number_of(cell: &Path) -> u32 {
    let whole = fs::canonicalize(cell).unwrap_or_else(|_| cell.to_owned());
    let hash = mrroc_core::payload::layout_hash(0, &whole.to_string_lossy());
    (hash ^ hash >> 32) as u32
}

/// The folders of those sessions of the cell in the file at `cell` that have processes.
///
/// # Errors
/// [`SessionError`]: the folder of sessions is not private, or cannot be read.
pub(super) fn sessions_of(cell: &Path) -> Result<Vec<PathBuf>, SessionError> {
    let (base, number) = (base()?, number_of(cell));
    let entries = fs::read_dir(&base).map_err(at(&base))?.flatten();
    let ours = entries.filter(|entry| {
        let name = entry.file_name().to_str().and_then(read_name);
        name.is_some_and(|(cell, _)| cell == number)
    });
    Ok(ours.map(|entry| entry.path()).filter(|folder| is_used(folder)).collect())
}

/// The number of the session in a folder.
pub(super) fn number_of_session(folder: &Path) -> Option<u64> {
    folder.file_name()?.to_str().and_then(read_name).map(|(_, number)| number)
}

/// Whether a session has processes: the lock of one that has ended or crashed is free, or gone.
pub(super) fn is_used(folder: &Path) -> bool {
    File::open(folder.join("lock")).is_ok_and(|lock| lock.try_lock().is_err())
}

/// Whether a signal or a debugger has stopped a process.
pub(super) fn is_stopped(pid: u32) -> bool {
    let stat = fs::read_to_string(format!("/proc/{pid}/stat")).unwrap_or_default();
    // The state comes after the name, which is in parentheses and may contain any character.
    stat.rsplit_once(')').is_some_and(|(_, rest)| matches!(rest.trim_start().chars().next(), Some('T' | 't')))
}

/// The prefix of the names of a session's segments.
pub(super) fn prefix(number: u64) -> String {
    format!("mrroc_{number:012x}_")
}

/// Reads a name such as `0123abcd-0123456789ab`: the number of the cell and the number of the session.
fn read_name(name: &str) -> Option<(u32, u64)> {
    let (cell, number) = name.split_once('-')?;
    let right = cell.len() == 8 && number.len() == 12;
    Some((u32::from_str_radix(cell, 16).ok()?, u64::from_str_radix(number, 16).ok()?)).filter(|_| right)
}

/// The paths of the shared memory of a session.
fn segments(number: u64) -> impl Iterator<Item = PathBuf> {
    let prefix = prefix(number);
    let names = fs::read_dir(SHARED_MEMORY).into_iter().flatten().flatten();
    let is_its =
        move |entry: &DirEntry| entry.file_name().to_str().is_some_and(|name| name.starts_with(&prefix));
    names.filter(is_its).map(|entry| entry.path())
}

/// Removes the files of a session and no others.
fn remove(folder: &Path, number: u64) {
    for segment in segments(number) {
        // What cannot be removed now is removed by the next launch.
        drop(fs::remove_file(segment));
    }
    drop(fs::remove_dir_all(folder));
}

/// The folder of all sessions of this user.
pub(super) fn base() -> Result<PathBuf, SessionError> {
    let user = rustix::process::getuid().as_raw();
    let runtime = std::env::var_os("XDG_RUNTIME_DIR").map(PathBuf::from);
    let runtime = runtime.filter(|folder| folder.is_absolute() && folder.is_dir());
    let base =
        runtime.map_or_else(|| PathBuf::from(format!("/tmp/mrroc-{user}")), |folder| folder.join("mrroc"));
    match DirBuilder::new().mode(0o700).create(&base) {
        Ok(()) => {}
        Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
        Err(error) => return Err(at(&base)(error)),
    }
    let kind = fs::symlink_metadata(&base).map_err(at(&base))?;
    if !kind.is_dir() || kind.uid() != user || kind.mode() & 0o077 != 0 {
        return Err(SessionError::NotPrivate(base));
    }
    Ok(base)
}

fn open(path: &Path) -> io::Result<File> {
    OpenOptions::new().read(true).write(true).create(true).truncate(false).mode(0o600).open(path)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fault_72_a_foreign_file_among_the_names_of_a_session_is_told_and_removed_but_not_followed() {
        let base = std::env::temp_dir().join(format!("mrroc-s{}", std::process::id()));
        fs::create_dir_all(&base).expect("a folder");
        let victim = base.join("victim");
        fs::write(&victim, "text").expect("a file");
        let mode = |path: &Path| path.metadata().expect("there").mode() & 0o7777;
        let before = mode(&victim);
        let session = Session::make(&base, 1, CellId(1)).expect("a session");
        assert_eq!(mode(session.folder()), 0o700);
        session.check_names().expect("nothing is there yet");
        let link = Path::new(SHARED_MEMORY).join(format!("{}0", prefix(session.number())));
        std::os::unix::fs::symlink(&victim, &link).expect("a link");
        let told = session.check_names().expect_err("a link").to_string();
        assert!(told.contains(" was made by user ") && told.contains("\n help: start again"), "{told}");
        drop(session);
        assert!(link.symlink_metadata().is_err() && mode(&victim) == before);
        fs::remove_dir_all(base).expect("removed");
    }

    #[test]
    fn only_names_of_sessions_are_read_as_such() {
        assert_eq!(read_name("0123abcd-0000000000ff"), Some((0x0123_abcd, 0xff)));
        for other in ["0123abcd.cell", "making", "0123abcd-ff", "-0123456789ab", "0123abcd-0123456789ag"] {
            assert_eq!(read_name(other), None, "{other}");
        }
    }
}
