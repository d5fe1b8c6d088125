//! A console's side of the connection: finds the cell that runs, asks and hears.

use std::io::{self, BufReader, ErrorKind, Write};
use std::os::unix::net::UnixStream;
use std::path::{Path, PathBuf};

use super::protocol::{Heard, Request};
use super::service::SOCKET;
use crate::session::{SessionError, sessions_of};

/// No cell is there to be operated.
#[derive(Debug, thiserror::Error)]
pub enum NoCell {
    /// Nobody runs it.
    #[error(
        "no processes run the cell of {0}\n help: start it in another terminal: --processes; --cell FILE names another one"
    )]
    NotRun(PathBuf),
    /// It has no console server.
    #[error(
        "the cell of {0} takes no orders now\n help: it is starting or ending, or runs under the virtual clock, which waits for nobody"
    )]
    Closed(PathBuf),
    /// Its sessions cannot be looked at.
    #[error(transparent)]
    Session(#[from] SessionError),
}

/// A connection to the console server of a running cell: its two directions.
pub struct Caller {
    pub asks: Asks,
    pub hears: Hears,
}

/// What a console asks by.
pub struct Asks(UnixStream);

/// What it hears by.
pub struct Hears(BufReader<UnixStream>);

impl Caller {
    /// Connects to the cell of the file at `cell`.
    ///
    /// # Errors
    /// [`NoCell`]
    pub fn find(cell: &Path) -> Result<Caller, NoCell> {
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

    /// Asks for something, and hears what comes of it.
    ///
    /// # Errors
    /// The console_server is gone, or what came is nothing that a console server says.
    pub fn ask(&mut self, request: &Request) -> io::Result<Heard> {
        self.asks.ask(request)?;
        self.hears.hear()
    }
}

impl Asks {
    /// Asks for something.
    ///
    /// # Errors
    /// The console_server is gone.
    pub fn ask(&mut self, request: &Request) -> io::Result<()> {
        self.0.write_all(format!("{request}\n").as_bytes())
    }
}

impl Hears {
    /// Waits for the next answer or picture.
    ///
    /// # Errors
    /// The console_server is gone, or what came is nothing that a console server says.
    pub fn hear(&mut self) -> io::Result<Heard> {
        let over = || io::Error::new(ErrorKind::UnexpectedEof, "the cell has ended");
        Heard::read(&mut self.0)?.ok_or_else(over)
    }
}
