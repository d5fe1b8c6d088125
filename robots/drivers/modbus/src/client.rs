//! Questions to a device that speaks Modbus TCP, one at a time, and its answers.
//!
//! In: questions, the time, and the bytes that have come. Out: the bytes of questions; answers, within a time that is declared here, or
//! why there are none. Nothing here waits: it belongs to a [`Protocol`](mrroc_driver_kit::Protocol).
//!
//! A gateway that has given up a question (exception 11) may still pass on its answer later. By its transaction's number it is known to
//! belong to an earlier question, and is dropped, as the Messaging Implementation Guide 1.0b asks (section 4.4.1). A gateway that
//! gives such an answer the number of the next question cannot be told from one that answers it: so after exception 11 nothing is to
//! be asked for [a while](Client::may_ask_from).

use core::time::Duration;

use mrroc::robot::{DriveFault, RobotStop, StopCause};
use mrroc_driver_kit::Received;

use crate::message::{Answer, Header, MAX_FRAME, NoAnswer, Question, UnitRequest};

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
    /// The number of the last question, and how many there were, as far as their numbers tell them apart.
    transaction: u16,
    count: u16,
    /// The question that is not answered, and until when it must be.
    asked: Option<(Question, Duration)>,
    may_ask_from: Duration,
    /// What has come of the answer, with a byte more than any may have.
    came: [u8; MAX_FRAME + 1],
    len: usize,
    is_closed: bool,
}

impl Client {
    /// Asks a unit, whose whole answer to a question may take so long.
    #[must_use]
    pub const fn new(unit: u8, timeout: Duration) -> Client {
        Client {
            unit,
            timeout,
            transaction: 0,
            count: 0,
            asked: None,
            may_ask_from: Duration::ZERO,
            came: [0; MAX_FRAME + 1],
            len: 0,
            is_closed: false,
        }
    }

    /// Takes in what has come.
    pub fn receive(&mut self, received: &Received<'_>) {
        let mut bytes = received.bytes;
        loop {
            let (fits, more) = bytes.split_at(bytes.len().min(self.came.len() - self.len));
            self.came[self.len..self.len + fits.len()].copy_from_slice(fits);
            self.len += fits.len();
            self.drop_earlier();
            bytes = more;
            // More than fits is no answer, whatever follows.
            if bytes.is_empty() || self.len == self.came.len() {
                break;
            }
        }
        self.is_closed |= received.is_closed;
    }

    /// Asks this now: appends the question to what is to be sent. One before that was not answered is forgotten.
    pub fn ask(&mut self, now: Duration, what: UnitRequest, send: &mut Vec<u8>) {
        self.transaction = self.transaction.wrapping_add(1);
        self.count = self.count.saturating_add(1).min(u16::MAX / 2);
        let question = Question { transaction: self.transaction, unit: self.unit, what };
        send.extend_from_slice(question.bytes().as_slice());
        self.asked = Some((question, now + self.timeout));
    }

    /// From when on something may be asked: after exception 11 the answer that its gateway has given up may come for as long as an
    /// answer may take.
    #[must_use]
    pub const fn may_ask_from(&self) -> Duration {
        self.may_ask_from
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
        // The rest of an answer to an earlier question is still to come.
        let is_earlier =
            Header::of(self.came()).is_ok_and(|first| first.is_some_and(|one| self.is_earlier(one)));
        let first = whole(self.came()).unwrap_or(self.len);
        let answer = if is_earlier { Ok(None) } else { question.answer(&self.came[..first]) };
        if answer == Ok(None) {
            return match () {
                () if self.is_closed => Err(Broken::Closed),
                () if now >= until => Err(Broken::Silent),
                () => Ok(None),
            };
        }
        self.asked = None;
        self.remove(0, first);
        self.drop_earlier();
        if answer == Err(NoAnswer::Exception(NoAnswer::GATEWAY)) {
            self.may_ask_from = now + self.timeout;
        }
        Ok(answer?)
    }

    fn came(&self) -> &[u8] {
        &self.came[..self.len]
    }

    /// Whether a frame belongs to a question before the one that is to be answered.
    fn is_earlier(&self, frame: Header) -> bool {
        let ago = self.transaction.wrapping_sub(frame.transaction);
        (u16::from(self.asked.is_some())..self.count).contains(&ago)
    }

    /// Drops whole answers to questions that were answered or given up before.
    fn drop_earlier(&mut self) {
        let mut at = 0;
        while let Some(len) = whole(&self.came()[at..]) {
            let header = Header::of(&self.came()[at..]).ok().flatten();
            if header.is_some_and(|header| self.is_earlier(header)) {
                self.remove(at, len);
            } else {
                at += len;
            }
        }
    }

    /// Removes so many of the bytes that have come.
    fn remove(&mut self, at: usize, len: usize) {
        self.came.copy_within(at + len..self.len, at);
        self.len -= len;
    }
}

/// How long the first frame is, where it has come whole.
fn whole(came: &[u8]) -> Option<usize> {
    let header = Header::of(came).ok().flatten()?;
    (header.frame_len <= came.len()).then_some(header.frame_len)
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

    /// A frame to a question with this number about one input register of unit 1.
    fn frame(transaction: u16, value: u8) -> [u8; 11] {
        let [high, low] = transaction.to_be_bytes();
        [high, low, 0, 0, 0, 5, 1, 4, 2, 0, value]
    }

    fn value(client: &mut Client, at: Duration) -> Result<Option<u16>, Broken> {
        client.answer(at).map(|answer| answer.map(|answer| answer.registers()[0]))
    }

    const GIVEN_UP: [u8; 9] = [0, 1, 0, 0, 0, 3, 1, 0x84, 11];

    #[test]
    fn an_answer_that_comes_again_is_no_answer_to_the_next_question() {
        let (mut client, mut sent) = (Client::new(1, ms(200)), Vec::new());
        client.ask(ms(0), READ, &mut sent);
        // Twice at once, and a third time when nothing is asked.
        client.receive(&received(&[frame(1, 7), frame(1, 7)].concat()));
        assert_eq!(value(&mut client, ms(0)), Ok(Some(7)));
        client.receive(&received(&ANSWER));
        assert_eq!(client.answer(ms(1)), Ok(None));
        client.ask(ms(2), READ, &mut sent);
        assert_eq!((sent[1], sent[13]), (1, 2));
        // A fourth time when the next one is.
        client.receive(&received(&ANSWER));
        assert_eq!(client.answer(ms(2)), Ok(None));
        client.receive(&received(&frame(2, 8)));
        assert_eq!(value(&mut client, ms(3)), Ok(Some(8)));
    }

    #[test]
    fn fault_175_what_a_gateway_has_given_up_and_passes_on_late_is_no_answer_to_the_next_question() {
        let given_up = || {
            let mut client = asked();
            client.receive(&received(&GIVEN_UP));
            assert_eq!(client.answer(ms(100)), Err(NoAnswer::Exception(11).into()));
            // As long as an answer may take.
            assert_eq!(client.may_ask_from(), ms(300));
            client.ask(ms(300), READ, &mut Vec::new());
            client
        };
        // Before the answer and after it, at once and in pieces.
        let (late, right) = (frame(1, 7), frame(2, 8));
        for piece in 1..=22 {
            for both in [[late, right].concat(), [right, late].concat()] {
                let mut client = given_up();
                let mut read = Vec::new();
                for bytes in both.chunks(piece) {
                    client.receive(&received(bytes));
                    read.extend(value(&mut client, ms(301)).expect("the late one is none"));
                }
                assert_eq!(read, [8], "pieces of {piece}");
                client.ask(ms(302), READ, &mut Vec::new());
                client.receive(&received(&frame(3, 9)));
                assert_eq!(value(&mut client, ms(303)), Ok(Some(9)), "pieces of {piece}");
            }
        }
        // It does not count as an answer, however often it comes.
        let mut client = given_up();
        client.receive(&received(&late.repeat(100)));
        assert_eq!(client.answer(ms(499)), Ok(None));
        client.receive(&received(&late[..8]));
        assert_eq!(client.answer(ms(500)), Err(Broken::Silent));
        let mut client = given_up();
        client.receive(&received(&[&late.repeat(100)[..], &right, &late.repeat(15)].concat()));
        assert_eq!(value(&mut client, ms(301)), Ok(Some(8)));
        assert_eq!(client.len, 0, "nothing is left of the late ones");
    }

    #[test]
    fn an_answer_with_the_right_number_and_another_function_or_unit_is_refused() {
        for (at, byte, why) in [(6, 2, NoAnswer::Unit), (7, 3, NoAnswer::Question), (8, 4, NoAnswer::Length)]
        {
            let mut client = asked();
            let mut other = ANSWER;
            other[at] = byte;
            client.receive(&received(&other));
            assert_eq!(client.answer(ms(11)), Err(why.into()));
        }
        // One that was never asked with this number: a device that does not return it.
        for never in [0, 2, 0x8000, 0xffff] {
            let mut client = asked();
            client.receive(&received(&frame(never, 7)));
            assert_eq!(client.answer(ms(11)), Err(NoAnswer::Transaction.into()), "{never}");
        }
    }

    #[test]
    fn numbers_begin_anew_after_65535_and_earlier_ones_are_still_known() {
        let mut client = Client::new(1, ms(200));
        for number in 1..=70_000_u32 {
            client.ask(ms(0), READ, &mut Vec::new());
            let late = frame(number.saturating_sub(2) as u16, 1);
            if number > 3 {
                client.receive(&received(&late));
            }
            client.receive(&received(&frame(number as u16, 2)));
            assert_eq!(value(&mut client, ms(0)), Ok(Some(2)), "{number}");
        }
    }

    #[test]
    fn more_than_a_frame_has_is_no_answer() {
        let mut client = asked();
        client.receive(&received(&[7; 1000]));
        client.receive(&received(&[7; 1000]));
        assert_eq!(client.answer(ms(11)), Err(NoAnswer::Protocol.into()));
    }
}
