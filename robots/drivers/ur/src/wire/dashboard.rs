//! The dashboard of a controller: commands in lines of text, an answer to each. PolyScope X has none.
//!
//! Used by a thread of its own, which may wait.

use std::io::{self, BufRead, BufReader, Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::time::Duration;

/// How long an answer may take.
const ANSWER: Duration = Duration::from_secs(2);

/// The most bytes of an answer.
const LONGEST: u64 = 1024;

/// A connection with it.
pub(super) struct Dashboard {
    stream: BufReader<TcpStream>,
}

impl Dashboard {
    /// Calls it, and reads its greeting.
    pub(super) fn call(address: SocketAddr) -> io::Result<Dashboard> {
        let stream = TcpStream::connect_timeout(&address, ANSWER)?;
        stream.set_read_timeout(Some(ANSWER))?;
        stream.set_write_timeout(Some(ANSWER))?;
        let mut dashboard = Dashboard { stream: BufReader::new(stream) };
        dashboard.line()?;
        Ok(dashboard)
    }

    /// What it answers to a command, in small letters.
    pub(super) fn ask(&mut self, command: &str) -> io::Result<String> {
        self.stream.get_mut().write_all(format!("{command}\n").as_bytes())?;
        self.line().map(|line| line.to_lowercase())
    }

    fn line(&mut self) -> io::Result<String> {
        let mut line = Vec::new();
        (&mut self.stream).take(LONGEST).read_until(b'\n', &mut line)?;
        if line.is_empty() {
            return Err(io::ErrorKind::UnexpectedEof.into());
        }
        Ok(String::from_utf8_lossy(&line).trim().to_owned())
    }
}
