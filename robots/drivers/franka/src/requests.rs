//! Requests to a robot, and its answers, as bytes of one connection.
//!
//! In: requests, and the bytes that come. Out: the bytes of requests, each with a number of its own, and the answers that
//! have come as a whole. Nothing here has a clock or a socket.

use crate::message::{Answer, LONGEST_ANSWER, LONGEST_REQUEST, Request};

/// What was asked for in a connection, and what has come of answers.
#[derive(Debug)]
pub struct Requests {
    /// What has come of the next answers.
    came: [u8; 4 * LONGEST_ANSWER],
    len: usize,
    /// The number of the last request.
    last: u32,
    asked: [u8; LONGEST_REQUEST],
}

impl Requests {
    /// A connection in which nothing was said.
    pub const fn new() -> Requests {
        Requests { came: [0; 4 * LONGEST_ANSWER], len: 0, last: 0, asked: [0; LONGEST_REQUEST] }
    }

    /// The bytes of a request, and its number.
    pub fn write(&mut self, request: Request) -> (u32, &[u8]) {
        self.last += 1;
        let len = request.write(self.last, &mut self.asked);
        (self.last, &self.asked[..len])
    }

    /// Where bytes of answers go that come next.
    pub fn room(&mut self) -> &mut [u8] {
        &mut self.came[self.len..]
    }

    /// So many have come, at the front of the [room](Requests::room).
    pub fn filled(&mut self, len: usize) {
        self.len += len;
    }

    /// The next answer, if it has come as a whole.
    ///
    /// # Errors
    /// What comes is no answer.
    #[allow(clippy::result_unit_err)]
    pub fn next(&mut self) -> Result<Option<Answer>, ()> {
        let read = Answer::read(&self.came[..self.len])?;
        Ok(read.map(|(answer, size)| {
            self.came.copy_within(size..self.len, 0);
            self.len -= size;
            answer
        }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn come(requests: &mut Requests, bytes: &[u8]) {
        requests.room()[..bytes.len()].copy_from_slice(bytes);
        requests.filled(bytes.len());
    }

    #[test]
    fn answers_are_taken_as_they_come() {
        let mut requests = Requests::new();
        assert_eq!(requests.next(), Ok(None));
        let (id, asked) = requests.write(Request::Recover);
        assert_eq!((id, asked), (1, &[10, 0, 0, 0, 1, 0, 0, 0, 12, 0, 0, 0][..]));
        // One of an older request, and this one with three bytes of padding, as some controllers send; byte by byte.
        let older = [1, 0, 0, 0, 0, 0, 0, 0, 13, 0, 0, 0, 2];
        let this = [10, 0, 0, 0, 1, 0, 0, 0, 16, 0, 0, 0, 3, 0, 0, 0];
        let mut answers = Vec::new();
        for (place, byte) in [older.as_slice(), &this].concat().into_iter().enumerate() {
            come(&mut requests, &[byte]);
            answers.extend(requests.next().expect("answers").map(|answer| (place, answer.id, answer.status)));
        }
        assert_eq!(answers, [(12, 0, 2), (28, 1, 3)]);
        // Both at once.
        come(&mut requests, &[older.as_slice(), &this].concat());
        let ids = [requests.next(), requests.next(), requests.next()];
        assert_eq!(
            ids.map(|answer| answer.expect("answers").map(|answer| answer.id)),
            [Some(0), Some(1), None]
        );
        assert_eq!(requests.room().len(), 4 * LONGEST_ANSWER);
        // An answer has at least one byte, and none is so long.
        for size in [12, LONGEST_ANSWER as u8 + 1] {
            let mut requests = Requests::new();
            come(&mut requests, &[10, 0, 0, 0, 1, 0, 0, 0, size, 0, 0, 0]);
            assert_eq!(requests.next(), Err(()));
        }
    }
}
