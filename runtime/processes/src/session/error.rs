//! Why a session could not be made, in words for who launched the cell.

use std::io;
use std::path::PathBuf;

use crate::machine::identity::{AlreadyTaken, Holder};

/// Why a session could not be made.
#[derive(Debug, thiserror::Error)]
pub(crate) enum SessionError {
    /// The cell is running already.
    #[error("the cell is run by process {0} already\n help: wait for it, or stop it: kill {0}")]
    Running(u32),
    /// The cell is running already, for another user.
    #[error(
        "the cell is run by process {0} of user {1} already\n help: wait for it, or ask that user to stop it"
    )]
    RunningForAnother(u32, u32),
    /// A process that does not say who it is has taken the cell's name.
    #[error(
        "another process of this machine has taken the name of the cell\n help: see `grep @mrroc /proc/net/unix`"
    )]
    NameTaken,
    /// A robot's hardware belongs to another cell that runs.
    #[error(
        "{hardware} is driven by another cell{by}\n help: wait for that cell, or stop it; what a driver names is in its `hardware`"
    )]
    HardwareTaken {
        /// What the driver says that it is.
        hardware: String,
        /// The process that runs the other cell, in words.
        by: String,
    },
    /// Processes of a launch from another folder that crashed have not ended yet.
    #[error("processes of an earlier launch of the cell are still there\n help: see `ps -ef`, and stop them")]
    Parts,
    /// The names of the cell could not be taken.
    #[error("the machine has no sockets for the cell's names: {0}")]
    Names(io::Error),
    /// Processes of a launch that crashed have not ended yet.
    #[error(
        "processes of an earlier launch of the cell are still there, in {0}\n help: see `ps -ef`, and stop them"
    )]
    Orphans(PathBuf),
    /// The folder of sessions could be changed by other users.
    #[error("{0} must be a folder of yours that nobody else may enter\n help: chmod 700 it, or remove it")]
    NotPrivate(PathBuf),
    /// A file in shared memory has a name of the session and is another user's, or no ordinary file.
    #[error(
        "{0} was made by user {1} under a name of this cell, which therefore cannot start\n help: start again: each launch takes \
         new names. If it happens again, somebody does this on purpose: see who is user {1}, and what runs as this user"
    )]
    Foreign(PathBuf, u32),
    /// The path of the session's folder is too long for sockets.
    #[error(
        "the path {0} is too long for sockets: at most 28 bytes\n help: set XDG_RUNTIME_DIR to a shorter one"
    )]
    TooLong(PathBuf),
    /// Reading or writing failed.
    #[error("{0}: {1}{help}", help = crate::machine::capacity::remedy(.1))]
    Io(PathBuf, io::Error),
}

impl From<AlreadyTaken> for SessionError {
    fn from(taken: AlreadyTaken) -> SessionError {
        match taken {
            AlreadyTaken::Cell(Some(holder)) if holder.is_ours() => SessionError::Running(holder.pid),
            AlreadyTaken::Cell(Some(Holder { pid, user })) => SessionError::RunningForAnother(pid, user),
            AlreadyTaken::Cell(None) => SessionError::NameTaken,
            AlreadyTaken::Hardware(hardware, holder) => {
                let by =
                    holder.map(|Holder { pid, user }| format!(", which process {pid} of user {user} runs"));
                SessionError::HardwareTaken { hardware, by: by.unwrap_or_default() }
            }
            AlreadyTaken::Io(error) => SessionError::Names(error),
        }
    }
}
