//! A console's side of the connection.
//!
//! In: the path of a cell's file, then requests. Out: a connection to the console server of that cell, then its answers
//! and pictures.

use std::io::{self, BufReader, ErrorKind, Write};
use std::os::unix::net::UnixStream;
use std::path::{Path, PathBuf};

use super::protocol::{Heard, Request};
use super::service::SOCKET;
use crate::session::{SessionError, sessions_of};

/// Why a console cannot connect to a cell.
#[derive(Debug, thiserror::Error)]
pub(crate) enum NoCell {
    /// The cell is not running.
    #[error(
        "no processes run the cell of {0}\n help: start it in another terminal: --processes; --cell FILE names another one"
    )]
    NotRun(PathBuf),
    /// The cell runs, but has no console server.
    #[error(
        "the cell of {0} takes no orders now\n help: it is starting or ending, or runs under the virtual clock, which waits for nobody"
    )]
    Closed(PathBuf),
    /// The folder of sessions cannot be read.
    #[error(transparent)]
    Session(#[from] SessionError),
}

/// A connection to the console server of a running cell, with both directions.
pub struct Caller {
    /// The direction to the console server.
    pub asks: Asks,
    /// The direction from the console server.
    pub hears: Hears,
}

/// The direction from a console to the console server.
pub struct Asks(UnixStream);

/// The direction from the console server to a console.
pub struct Hears(BufReader<UnixStream>);

impl Caller {
    /// Connects to the cell of the file at `cell`.
    ///
    /// # Errors
    /// [`NoCell`]
    pub(crate) fn find(cell: &Path) -> Result<Caller, NoCell> {
        let sessions = sessions_of(cell)?;
        let connect = |folder: &PathBuf| {
            let stream = UnixStream::connect(folder.join(SOCKET)).ok()?;
            Some(Caller { asks: Asks(stream.try_clone().ok()?), hears: Hears(BufReader::new(stream)) })
        };
        match sessions.iter().find_map(connect) {
            Some(caller) => Ok(caller),
            None if sessions.is_empty() => Err(NoCell::NotRun(cell.to_owned())),
            None => Err(NoCell::Closed(cell.to_owned())),
        }
    }

    /// Sends a request and waits for its answer.
    ///
    /// # Errors
    /// The console server is gone, or what came is neither an answer nor a picture.
    pub fn ask(&mut self, request: &Request) -> io::Result<Heard> {
        self.asks.ask(request)?;
        self.hears.hear()
    }
}

impl Asks {
    /// Sends a request.
    ///
    /// # Errors
    /// The console server is gone.
    pub fn ask(&mut self, request: &Request) -> io::Result<()> {
        self.0.write_all(format!("{request}\n").as_bytes())
    }
}

impl Hears {
    /// Waits for the next answer or picture.
    ///
    /// # Errors
    /// The console server is gone, or what came is neither an answer nor a picture.
    pub fn hear(&mut self) -> io::Result<Heard> {
        let over = || io::Error::new(ErrorKind::UnexpectedEof, "the cell has ended");
        Heard::read(&mut self.0)?.ok_or_else(over)
    }
}
