//! Requests to a robot, and its answers, over TCP.
//!
//! Before the cell runs an answer is waited for; then nothing here waits: what has come is taken, and a connection that has
//! ended is told.

#![expect(clippy::disallowed_methods, reason = "before the cell runs, the robot's answer is waited for")]

use core::time::Duration;
use std::io::{self, ErrorKind, Read, Write};
use std::net::{IpAddr, SocketAddr, TcpStream};
use std::time::Instant;

use crate::message::{Answer, LONGEST_ANSWER, LONGEST_REQUEST, Request};

/// A connection to a robot.
#[derive(Debug)]
pub struct Requests {
    stream: TcpStream,
    /// What has come of the next answers.
    bytes: [u8; 4 * LONGEST_ANSWER],
    len: usize,
    /// The number of the last request.
    last: u32,
}

impl Requests {
    /// Connects to the robot at `address`.
    ///
    /// # Errors
    /// Nobody answers there within `patience`.
    pub fn connect(address: SocketAddr, patience: Duration) -> io::Result<Requests> {
        let stream = TcpStream::connect_timeout(&address, patience)?;
        stream.set_nodelay(true)?;
        stream.set_nonblocking(true)?;
        Ok(Requests { stream, bytes: [0; 4 * LONGEST_ANSWER], len: 0, last: 0 })
    }

    /// This machine's address on the way to the robot.
    ///
    /// # Errors
    /// The connection has ended.
    pub fn own_address(&self) -> io::Result<IpAddr> {
        self.stream.local_addr().map(|address| address.ip())
    }

    /// Sends a request, and says its number.
    ///
    /// # Errors
    /// The connection has ended, or takes nothing.
    pub fn ask(&mut self, request: Request) -> io::Result<u32> {
        self.last += 1;
        let mut bytes = [0; LONGEST_REQUEST];
        let len = request.write(self.last, &mut bytes);
        // A request is far shorter than what a connection takes at once.
        self.stream.write_all(&bytes[..len])?;
        Ok(self.last)
    }

    /// The next answer, if it has come.
    ///
    /// # Errors
    /// The connection has ended, or what comes is no answer.
    pub fn answer(&mut self) -> io::Result<Option<Answer>> {
        match self.stream.read(&mut self.bytes[self.len..]) {
            Ok(0) if self.len < self.bytes.len() => return Err(ErrorKind::UnexpectedEof.into()),
            Ok(len) => self.len += len,
            Err(why) if matches!(why.kind(), ErrorKind::WouldBlock | ErrorKind::Interrupted) => {}
            Err(why) => return Err(why),
        }
        let read =
            Answer::read(&self.bytes[..self.len]).map_err(|()| io::Error::from(ErrorKind::InvalidData))?;
        Ok(read.map(|(answer, size)| {
            self.bytes.copy_within(size..self.len, 0);
            self.len -= size;
            answer
        }))
    }

    /// Waits for the answer to the request of this number.
    ///
    /// # Errors
    /// As [`Requests::answer`], or it does not come in time.
    pub fn wait(&mut self, id: u32, patience: Duration) -> io::Result<Answer> {
        let until = Instant::now() + patience;
        while Instant::now() < until {
            match self.answer()? {
                Some(answer) if answer.id == id => return Ok(answer),
                Some(_) => {}
                None => std::thread::sleep(Duration::from_micros(200)),
            }
        }
        Err(ErrorKind::TimedOut.into())
    }
}

#[cfg(test)]
mod tests {
    use std::net::TcpListener;

    use super::*;

    #[test]
    fn answers_are_taken_as_they_come_and_an_end_of_the_connection_is_told() {
        let robot = TcpListener::bind("127.0.0.1:0").expect("a port");
        let patience = Duration::from_secs(5);
        let mut requests =
            Requests::connect(robot.local_addr().expect("bound"), patience).expect("connected");
        let (mut stream, _) = robot.accept().expect("somebody");
        assert_eq!(requests.answer().expect("open"), None);
        let id = requests.ask(Request::Recover).expect("sent");
        let mut asked = [0; 12];
        stream.read_exact(&mut asked).expect("a request");
        assert_eq!(asked, [10, 0, 0, 0, 1, 0, 0, 0, 12, 0, 0, 0]);
        // One of an older request, and this one with three bytes of padding, as some controllers send.
        let older = [1, 0, 0, 0, 0, 0, 0, 0, 13, 0, 0, 0, 2];
        let this = [10, 0, 0, 0, 1, 0, 0, 0, 16, 0, 0, 0, 3, 0, 0, 0];
        stream.write_all(&[older.as_slice(), &this].concat()).expect("sent");
        assert_eq!(requests.wait(id, patience).expect("an answer").status, 3);
        drop(stream);
        let ended = loop {
            match requests.answer() {
                Ok(None) => std::thread::sleep(Duration::from_millis(1)),
                other => break other,
            }
        };
        assert_eq!(ended.expect_err("over").kind(), ErrorKind::UnexpectedEof);
    }
}
