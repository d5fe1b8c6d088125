//! The lock of a cell: one launcher at a time has it, and removes what crashed launches left behind.

use std::fs::{self, File, TryLockError};
use std::io::{Read, Seek, Write};
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use super::{Session, SessionError, at, base, is_used, number_of, open, read_name, remove};
use crate::machine::identity::{CellId, Names};

/// How long processes of a crashed launch may still brake their robots.
const BRAKING: Duration = Duration::from_secs(3);

/// The right to run a cell, which one launcher at a time has.
#[derive(Debug)]
pub(crate) struct CellLock {
    base: PathBuf,
    path: PathBuf,
    cell: u32,
    id: CellId,
    /// The file is locked as long as it is open.
    _file: File,
    /// The cell's own file: as long as it is open, no other file gets its identity.
    _cell: Option<File>,
    _names: Names,
}

impl CellLock {
    /// Takes the lock of the cell in the file at `cell`, in the folder of sessions and for the whole machine, and that of its
    /// hardware.
    pub fn take(cell: &Path, hardware: &[String]) -> Result<CellLock, SessionError> {
        let own = File::open(cell).ok();
        let base = base()?;
        let hash = number_of(cell);
        let path = base.join(format!("{hash:08x}.cell"));
        loop {
            let mut file = open(&path).map_err(at(&path))?;
            match file.try_lock() {
                Ok(()) => {}
                Err(TryLockError::WouldBlock) => {
                    let mut holder = String::new();
                    file.read_to_string(&mut holder).map_err(at(&path))?;
                    match holder.trim().parse() {
                        Ok(holder) => return Err(SessionError::Running(holder)),
                        // The other launcher has the lock and is about to write its number.
                        Err(_) => std::thread::sleep(Duration::from_millis(1)),
                    }
                    continue;
                }
                Err(TryLockError::Error(error)) => return Err(at(&path)(error)),
            }
            // The previous holder may have removed the file after this process opened it: such a lock does not count.
            let ours = file.metadata().map_err(at(&path))?.ino();
            if fs::metadata(&path).is_ok_and(|now| now.ino() == ours) {
                file.set_len(0).and_then(|()| file.rewind()).map_err(at(&path))?;
                write!(file, "{}", std::process::id()).map_err(at(&path))?;
                let id = CellId::of(cell);
                let names = Names::take(id, hardware);
                if names.is_err() {
                    // As at the end of a run.
                    drop(fs::remove_file(&path));
                }
                return Ok(CellLock { base, path, cell: hash, id, _file: file, _cell: own, _names: names? });
            }
        }
    }

    /// Makes a new session of the cell, after the remains of crashed sessions are removed.
    pub fn session(&self) -> Result<Session, SessionError> {
        let (_making, left) = self.wait_for_remains(|| self.id.has_parts().then_some(SessionError::Parts))?;
        left.map_or_else(|| Session::make(&self.base, self.cell, self.id), Err)
    }

    /// Removes what crashed sessions of this user have left, without making a new one.
    pub fn remove_remains(&self) -> Result<(), SessionError> {
        self.wait_for_remains(|| None).map(drop)
    }

    /// Removes what crashed sessions have left. While processes of this cell's still brake their robots, or there is something `else_left`, it
    /// is tried again, for as long as they may brake. The right to make a session, and what is left in its way.
    fn wait_for_remains(
        &self,
        else_left: impl Fn() -> Option<SessionError>,
    ) -> Result<(File, Option<SessionError>), SessionError> {
        let until = Instant::now() + BRAKING;
        loop {
            let making = self.begin_making()?;
            let left = self.remove_crashed()?.map(SessionError::Orphans).or_else(&else_left);
            if left.is_none() || Instant::now() > until {
                return Ok((making, left));
            }
            drop(making);
            std::thread::sleep(Duration::from_millis(20));
        }
    }

    /// One launcher at a time makes or removes sessions, so that a folder without a lock is the rest of a crashed launch and not a
    /// folder that is being made.
    fn begin_making(&self) -> Result<File, SessionError> {
        let guard = self.base.join("making");
        let making = open(&guard).map_err(at(&guard))?;
        making.lock().map_err(at(&guard))?;
        Ok(making)
    }

    /// Removes the sessions that no process is in; returns the folder of a session of this cell that still has
    /// processes.
    fn remove_crashed(&self) -> Result<Option<PathBuf>, SessionError> {
        let mut alive = None;
        for entry in fs::read_dir(&self.base).map_err(at(&self.base))?.flatten() {
            let folder = entry.path();
            let Some((cell, number)) = entry.file_name().to_str().and_then(read_name) else { continue };
            if is_used(&folder) {
                if cell == self.cell {
                    alive = Some(folder);
                }
            } else {
                remove(&folder, number);
            }
        }
        Ok(alive)
    }
}

impl Drop for CellLock {
    fn drop(&mut self) {
        // The file is removed while it is locked, so that a launcher that opened it meanwhile sees that it is gone. If
        // it cannot be removed, it does no harm.
        drop(fs::remove_file(&self.path));
    }
}
