//! The dashboard of a controller: commands in lines of text, an answer to each. PolyScope X has none.
//!
//! In: the time, and the lines that come. Out: the next command, and what came of all of them. Nothing here has a clock or a socket.

use core::time::Duration;

use mrroc_driver_kit::Cutting;

/// How long the call of a dashboard, and then each of its answers, may take.
pub(super) const ANSWER: Duration = Duration::from_secs(2);

/// How long after the answer a protective stop is tried again to be released.
const AGAIN: Duration = Duration::from_millis(250);

/// The most bytes of an answer.
const LONGEST: usize = 1024;

/// How its stream is cut into lines.
pub(super) fn cut(bytes: &[u8]) -> Cutting {
    match bytes.iter().take(LONGEST).position(|byte| *byte == b'\n') {
        Some(end) => Cutting::Frame(end + 1),
        None if bytes.len() < LONGEST => Cutting::More,
        None => Cutting::Frame(LONGEST),
    }
}

/// What is wanted of a dashboard.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Aim {
    /// To know whether the controller is in remote control.
    Ask,
    /// To release a protective stop, as soon as the controller lets that be done.
    Unlock,
}

/// What came of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Outcome {
    /// The controller is in remote control, or does not know that.
    Remote,
    /// It is in local control.
    Local,
    /// The protective stop is being released.
    Released,
    /// The controller does not release it.
    Held,
    /// The dashboard does not answer.
    Silent,
}

/// What is to be done next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Next {
    /// Nothing: an answer, or a time, is waited for.
    Wait,
    /// To send this command and the end of a line.
    Send(&'static str),
    /// It is over.
    Over(Outcome),
}

/// What is waited for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Awaited {
    Greeting,
    /// The answer to one of these commands.
    Remote,
    Popup,
    Unlock,
    /// The time at which it is tried again.
    Again,
}

/// A conversation with a dashboard that has been called.
#[derive(Clone, Copy, Debug)]
pub(super) struct Dialogue {
    aim: Aim,
    awaited: Awaited,
    /// Until when that is waited for.
    due: Duration,
    /// Until when a protective stop is tried to be released.
    until: Duration,
}

impl Dialogue {
    /// From now on, until this time.
    pub(super) fn new(aim: Aim, now: Duration, until: Duration) -> Dialogue {
        Dialogue { aim, awaited: Awaited::Greeting, due: now + ANSWER, until }
    }

    /// What comes next at this time, where the dashboard has said a line or not, and may go on or not.
    pub(super) fn poll(&mut self, now: Duration, line: Option<&[u8]>, is_open: bool) -> Next {
        if self.awaited == Awaited::Again {
            return if now >= self.due { self.try_again(now) } else { Next::Wait };
        }
        let Some(line) = line else {
            return if is_open && now < self.due { Next::Wait } else { Next::Over(Outcome::Silent) };
        };
        let answer = String::from_utf8_lossy(line).trim().to_lowercase();
        match self.awaited {
            Awaited::Greeting => self.send(now, Awaited::Remote, "is in remote control"),
            Awaited::Remote if answer == "false" => Next::Over(Outcome::Local),
            Awaited::Remote if self.aim == Aim::Ask => Next::Over(Outcome::Remote),
            Awaited::Remote => self.send(now, Awaited::Popup, "close safety popup"),
            Awaited::Unlock if answer.contains("releasing") => Next::Over(Outcome::Released),
            Awaited::Unlock => {
                (self.awaited, self.due) = (Awaited::Again, now + AGAIN);
                Next::Wait
            }
            Awaited::Popup | Awaited::Again => self.try_again(now),
        }
    }

    fn try_again(&mut self, now: Duration) -> Next {
        if now >= self.until {
            return Next::Over(Outcome::Held);
        }
        self.send(now, Awaited::Unlock, "unlock protective stop")
    }

    fn send(&mut self, now: Duration, awaited: Awaited, command: &'static str) -> Next {
        (self.awaited, self.due) = (awaited, now + ANSWER);
        Next::Send(command)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const START: Duration = Duration::from_secs(3);
    const UNTIL: Duration = Duration::from_secs(13);

    fn said(dialogue: &mut Dialogue, line: &str) -> Next {
        dialogue.poll(START, Some(line.as_bytes()), true)
    }

    #[test]
    fn a_controller_is_asked_whether_it_is_in_remote_control() {
        for (answer, outcome) in [
            ("true\n", Outcome::Remote),
            (" FALSE\r\n", Outcome::Local),
            // Older software knows no such command.
            ("could not understand: 'is in remote control'\n", Outcome::Remote),
        ] {
            let mut dialogue = Dialogue::new(Aim::Ask, START, UNTIL);
            assert_eq!(dialogue.poll(START, None, true), Next::Wait);
            assert_eq!(said(&mut dialogue, "Connected\n"), Next::Send("is in remote control"));
            assert_eq!(said(&mut dialogue, answer), Next::Over(outcome), "{answer}");
        }
    }

    #[test]
    fn each_answer_is_waited_for_for_2_s() {
        let just = START + ANSWER - Duration::from_nanos(1);
        let mut dialogue = Dialogue::new(Aim::Unlock, START, UNTIL);
        assert_eq!(dialogue.poll(just, None, true), Next::Wait);
        assert_eq!(dialogue.poll(START + ANSWER, None, true), Next::Over(Outcome::Silent));
        assert_eq!(dialogue.poll(just, None, false), Next::Over(Outcome::Silent), "it is closed");
        assert_eq!(dialogue.poll(just, Some(b"Connected\n"), true), Next::Send("is in remote control"));
        assert_eq!(dialogue.poll(just + ANSWER, None, true), Next::Over(Outcome::Silent));
    }

    #[test]
    fn a_protective_stop_is_tried_to_be_released_every_250_ms_until_it_is_or_time_is_over() {
        let mut dialogue = Dialogue::new(Aim::Unlock, START, UNTIL);
        assert_eq!(said(&mut dialogue, "Connected\n"), Next::Send("is in remote control"));
        assert_eq!(said(&mut dialogue, "true\n"), Next::Send("close safety popup"));
        assert_eq!(said(&mut dialogue, "closing safety popup\n"), Next::Send("unlock protective stop"));
        assert_eq!(said(&mut dialogue, "Cannot unlock protective stop until 5s\n"), Next::Wait);
        for trial in 1..40 {
            let due = START + trial * AGAIN;
            assert_eq!(dialogue.poll(due - Duration::from_nanos(1), None, true), Next::Wait);
            assert_eq!(dialogue.poll(due, None, true), Next::Send("unlock protective stop"));
            let mut released = dialogue;
            let releasing = released.poll(due, Some(b"Protective stop releasing\n"), true);
            assert_eq!(releasing, Next::Over(Outcome::Released));
            assert_eq!(dialogue.poll(due, Some(b"Cannot unlock\n"), true), Next::Wait);
        }
        assert_eq!(dialogue.poll(UNTIL, None, true), Next::Over(Outcome::Held));
    }

    #[test]
    fn lines_are_cut_at_their_ends_and_after_1024_bytes() {
        assert_eq!(cut(b"true"), Cutting::More);
        assert_eq!(cut(b"true\nmore"), Cutting::Frame(5));
        assert_eq!((cut(&[b'x'; 1023]), cut(&[b'x'; 1030])), (Cutting::More, Cutting::Frame(1024)));
    }
}
