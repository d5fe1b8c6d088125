//! Questions to a device that speaks Modbus TCP, one at a time, and its answers.
//!
//! In: questions, the time, and the bytes that have come. Out: the bytes of questions; answers, within a time that is declared here, or
//! why there are none. Nothing here waits: it belongs to a [`Protocol`](mrroc_driver_kit::Protocol).

use core::time::Duration;

use mrroc::robot::{DriveFault, RobotStop, StopCause};
use mrroc_driver_kit::Received;

use crate::message::{Answer, MAX_FRAME, NoAnswer, Question, UnitRequest};

/// How long a device may take to accept the connection.
pub const CONNECT: Duration = Duration::from_secs(1);

/// Why there is no answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Broken {
    /// Nobody accepts the connection.
    #[error("nothing accepts a connection at its address")]
    Unreachable,
    /// It was closed by the other end.
    #[error("the connection was closed")]
    Closed,
    /// The answer did not come in time.
    #[error("no answer came in time")]
    Silent,
    /// What came is no answer.
    #[error(transparent)]
    NoAnswer(#[from] NoAnswer),
}

impl Broken {
    /// The same as a text that lasts.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Broken::Unreachable => "nothing accepts a connection at its address",
            Broken::Closed => "the connection was closed",
            Broken::Silent => "no answer came in time",
            Broken::NoAnswer(why) => why.name(),
        }
    }
}

/// A connection that is lost, by its name.
#[must_use]
pub const fn lost(name: &'static str) -> DriveFault {
    DriveFault::Stopped(RobotStop::new(StopCause::CommunicationLost).named(name))
}

impl From<Broken> for DriveFault {
    fn from(broken: Broken) -> DriveFault {
        match broken {
            // It is connected well, and is another device, or not the unit that was said.
            Broken::NoAnswer(why @ NoAnswer::Exception(_)) if !why.passes() => DriveFault::Other(why.name()),
            _ => lost(broken.name()),
        }
    }
}

/// The side of a connection that asks.
///
/// ```
/// use core::time::Duration;
/// use mrroc_driver_kit::Received;
/// use mrroc_modbus::client::{Broken, Client};
/// use mrroc_modbus::message::{UnitRequest, Table};
///
/// let (mut client, mut sent) = (Client::new(1, Duration::from_millis(200)), Vec::new());
/// client.ask(Duration::ZERO, UnitRequest::Read(Table::InputRegisters, 0, 1), &mut sent);
/// assert_eq!(sent, [0, 1, 0, 0, 0, 6, 1, 4, 0, 0, 0, 1]);
/// client.receive(&Received { bytes: &[0, 1, 0, 0, 0, 5, 1, 4, 2, 0, 7], ..Received::default() });
/// let answer = client.answer(Duration::from_millis(3))?.expect("it is whole");
/// assert_eq!(answer.registers(), [7]);
/// # Ok::<(), Broken>(())
/// ```
#[derive(Debug)]
pub struct Client {
    unit: u8,
    /// How long the whole answer to a question may take.
    timeout: Duration,
    transaction: u16,
    /// The question that is not answered, and until when it must be.
    asked: Option<(Question, Duration)>,
    /// What has come of the answer, with a byte more than any may have.
    came: [u8; MAX_FRAME + 1],
    len: usize,
    is_closed: bool,
}

impl Client {
    /// Asks a unit, whose whole answer to a question may take so long.
    #[must_use]
    pub const fn new(unit: u8, timeout: Duration) -> Client {
        let (transaction, asked, came, len, is_closed) = (0, None, [0; MAX_FRAME + 1], 0, false);
        Client { unit, timeout, transaction, asked, came, len, is_closed }
    }

    /// Takes in what has come.
    pub fn receive(&mut self, received: &Received<'_>) {
        // More than fits is no answer, whatever follows.
        let len = received.bytes.len().min(self.came.len() - self.len);
        self.came[self.len..self.len + len].copy_from_slice(&received.bytes[..len]);
        self.len += len;
        self.is_closed |= received.is_closed;
    }

    /// Asks this now: appends the question to what is to be sent. One before that was not answered is forgotten.
    pub fn ask(&mut self, now: Duration, what: UnitRequest, send: &mut Vec<u8>) {
        self.transaction = self.transaction.wrapping_add(1);
        let question = Question { transaction: self.transaction, unit: self.unit, what };
        send.extend_from_slice(question.bytes().as_slice());
        self.asked = Some((question, now + self.timeout));
    }

    /// Until when an answer must have come; `None` while nothing is asked.
    #[must_use]
    pub fn until(&self) -> Option<Duration> {
        self.asked.map(|(_, until)| until)
    }

    /// The answer, once; `None` while it may still come, or nothing is asked.
    ///
    /// # Errors
    /// Why there is none. Only after a refusal that [passes](NoAnswer::passes) may something be asked again.
    pub fn answer(&mut self, now: Duration) -> Result<Option<Answer>, Broken> {
        let Some((question, until)) = self.asked else { return Ok(None) };
        let answer = question.answer(&self.came[..self.len]);
        if answer == Ok(None) {
            return match () {
                () if self.is_closed => Err(Broken::Closed),
                () if now >= until => Err(Broken::Silent),
                () => Ok(None),
            };
        }
        (self.asked, self.len) = (None, 0);
        Ok(answer?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::message::Table;

    const READ: UnitRequest = UnitRequest::Read(Table::InputRegisters, 0, 1);
    const ANSWER: [u8; 11] = [0, 1, 0, 0, 0, 5, 1, 4, 2, 0, 7];

    const fn ms(time: u64) -> Duration {
        Duration::from_millis(time)
    }

    fn asked() -> Client {
        let mut client = Client::new(1, ms(200));
        client.ask(ms(10), READ, &mut Vec::new());
        client
    }

    fn received(bytes: &[u8]) -> Received<'_> {
        Received { bytes, ..Received::default() }
    }

    #[test]
    fn an_answer_may_come_in_pieces_until_its_time_is_over() {
        let mut client = asked();
        assert_eq!(client.until(), Some(ms(210)));
        for byte in &ANSWER[..10] {
            client.receive(&received(core::slice::from_ref(byte)));
            assert_eq!(client.answer(ms(209)), Ok(None));
        }
        assert_eq!(client.answer(ms(210)), Err(Broken::Silent));
        // What has come by then counts, also where it is looked at late.
        client.receive(&received(&ANSWER[10..]));
        let answer = client.answer(ms(5000)).map(|answer| answer.map(|answer| answer.registers().to_vec()));
        assert_eq!((answer, client.until()), (Ok(Some(vec![7])), None));
    }

    #[test]
    fn the_last_answer_comes_before_the_end_of_the_connection() {
        let mut client = asked();
        client.receive(&Received { is_closed: true, ..received(&ANSWER) });
        assert!(matches!(client.answer(ms(11)), Ok(Some(_))));
        // Nobody asks, so nothing is wrong.
        assert_eq!(client.answer(ms(12)), Ok(None));
        client.ask(ms(13), READ, &mut Vec::new());
        assert_eq!(client.answer(ms(13)), Err(Broken::Closed));
    }

    #[test]
    fn each_question_has_a_number_of_its_own_and_what_comes_unasked_is_no_answer_to_the_next() {
        let (mut client, mut sent) = (Client::new(1, ms(200)), Vec::new());
        client.ask(ms(0), READ, &mut sent);
        client.receive(&received(&ANSWER));
        assert!(matches!(client.answer(ms(0)), Ok(Some(_))));
        client.receive(&received(&ANSWER));
        assert_eq!(client.answer(ms(1)), Ok(None));
        client.ask(ms(2), READ, &mut sent);
        assert_eq!((sent[1], sent[13]), (1, 2));
        assert_eq!(client.answer(ms(2)), Err(NoAnswer::Transaction.into()));
    }

    #[test]
    fn more_than_a_frame_has_is_no_answer() {
        let mut client = asked();
        client.receive(&received(&[7; 1000]));
        client.receive(&received(&[7; 1000]));
        assert_eq!(client.answer(ms(11)), Err(NoAnswer::Protocol.into()));
    }
}
