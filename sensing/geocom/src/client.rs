//! What is asked of an instrument, and what it answers: one question at a time.

use core::time::Duration;

use crate::angles::{Face, from_circles, to_circles};
use crate::protocol::{Answer, Code, Request};

/// Lines of text there and back.
pub trait Wire {
    /// Sends a line.
    ///
    /// # Errors
    /// [`Trouble::Closed`], or [`Trouble::Silent`] if nobody takes it.
    fn send(&mut self, line: &str) -> Result<(), Trouble>;

    /// The next line, without its end; `None` if none has come in time.
    ///
    /// # Errors
    /// [`Trouble::Closed`], or [`Trouble::Garbled`] of a line without an end.
    fn receive(&mut self, patience: Duration) -> Result<Option<String>, Trouble>;
}

/// Why there is no reading.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Trouble {
    /// No answer came, however often it was asked.
    #[error("no answer came in time: is the instrument on, and the speed of the port its own?")]
    Silent,
    /// No answer could be understood.
    #[error("no answer could be understood: compare the speed of the port, and shorten the cable")]
    Garbled,
    /// The instrument says what is wrong.
    #[error("the instrument answers {}: {}", .0.0, .0.meaning())]
    Refused(Code),
    /// The telescope is not in the face that was asked for.
    #[error("the telescope is in the other face than was asked for: leave it alone")]
    OtherFace,
    /// The line is closed.
    #[error("the serial port is closed: is its cable in?")]
    Closed,
}

/// How long answers are waited for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Patience {
    /// Where nothing turns; 3 s.
    pub answer: Duration,
    /// Where the instrument turns to a target; 30 s.
    pub turn: Duration,
    /// How often it is asked at most; 3.
    pub times: u32,
}

impl Default for Patience {
    fn default() -> Self {
        Self { answer: Duration::from_secs(3), turn: Duration::from_secs(30), times: 3 }
    }
}

/// What was measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measured {
    /// Horizontal angle from x to y, -pi to pi, and elevation \[rad\], both as of the first face.
    pub angles: [f64; 2],
    /// In which face.
    pub face: Face,
}

/// Lines that are thrown away before a question, and answers to others that are passed over after it: more is no instrument.
const MOST_BEFORE: usize = 64;
const MOST_OTHERS: usize = 8;

/// Who asks.
#[derive(Debug)]
pub struct Client<W> {
    wire: W,
    patience: Patience,
    transaction: u32,
    /// Whether the instrument knows checksums; `None` before its first answer.
    checks: Option<bool>,
}

impl<W: Wire> Client<W> {
    /// Over such a wire.
    #[must_use]
    pub const fn new(wire: W, patience: Patience) -> Self {
        Self { wire, patience, transaction: 0, checks: None }
    }

    /// Whether the instrument answers (`COM_NullProc`).
    ///
    /// # Errors
    /// [`Trouble`].
    pub fn greet(&mut self) -> Result<(), Trouble> {
        self.ask(0, &[], self.patience.answer).map(drop)
    }

    /// Turns the telescope over if need be, then about to these angles, lets the instrument find the target there, and measures.
    ///
    /// # Errors
    /// [`Trouble`].
    pub fn sight(&mut self, about: [f64; 2], face: Face) -> Result<Measured, Trouble> {
        let turn = self.patience.turn;
        for _ in 0..self.patience.times.max(1) {
            if face_of(self.ask(2026, &[], self.patience.answer)?.number(0))? == face {
                break;
            }
            // It turns the telescope over each time, so it is asked again only where the face says that it has not.
            match self.ask_once(9028, &[0.0, 0.0, 0.0], turn, true) {
                Ok(_) | Err(Trouble::Silent | Trouble::Garbled) => {}
                Err(Trouble::Refused(code)) if code.is_busy() => {}
                Err(other) => return Err(other),
            }
        }
        let [hz, v] = to_circles(about, face);
        // Position mode: normal; with target recognition.
        self.ask(9027, &[hz, v, 0.0, 1.0, 0.0], turn)?;
        let measured = self.measure()?;
        if measured.face == face { Ok(measured) } else { Err(Trouble::OtherFace) }
    }

    /// Measures where the telescope points, with the compensator (`TMC_GetAngle1`).
    ///
    /// # Errors
    /// [`Trouble`].
    pub fn measure(&mut self) -> Result<Measured, Trouble> {
        let answer = self.ask(2003, &[0.0], self.patience.answer)?;
        let (hz, v) = answer.number(0).zip(answer.number(1)).ok_or(Trouble::Garbled)?;
        let face = face_of(answer.number(8))?;
        Ok(Measured { angles: from_circles([hz, v], face), face })
    }

    /// Asks until there is an answer: again after silence, after one that cannot be understood, and while the instrument is busy. What is asked here may be
    /// asked twice. An answer to an earlier question is not taken, nor one without a checksum of an instrument that knows them.
    fn ask(&mut self, rpc: u32, parameters: &[f64], patience: Duration) -> Result<Answer, Trouble> {
        let mut trouble = Trouble::Silent;
        let times = self.patience.times.max(1);
        for time in 1..=times {
            match self.ask_once(rpc, parameters, patience, time < times) {
                Err(Trouble::Refused(code)) if code.is_busy() => trouble = Trouble::Refused(code),
                Err(again @ (Trouble::Silent | Trouble::Garbled)) => trouble = again,
                other => return other,
            }
        }
        Err(trouble)
    }

    /// Asks once; with a checksum, where it is not known whether the instrument knows them, if `guess` says so.
    fn ask_once(
        &mut self,
        rpc: u32,
        parameters: &[f64],
        patience: Duration,
        guess: bool,
    ) -> Result<Answer, Trouble> {
        self.transaction = (self.transaction + 1) % 8;
        let checked = self.checks.unwrap_or(guess);
        let request =
            Request { rpc, transaction: self.transaction, checked, parameters: parameters.to_vec() };
        // What came before it is no answer to it.
        let mut before = 0;
        while self.wire.receive(Duration::ZERO)?.is_some() {
            before += 1;
            if before > MOST_BEFORE {
                return Err(Trouble::Garbled);
            }
        }
        self.wire.send(&request.to_string())?;
        for _ in 0..MOST_OTHERS {
            let Some(line) = self.wire.receive(patience)? else { break };
            let answer = Answer::parse(&line).ok_or(Trouble::Garbled)?;
            // What an instrument could not read it may answer without a number.
            if answer.transaction != self.transaction
                && (answer.transport == Code::OK || answer.transaction != 0)
            {
                continue;
            }
            if answer.transport == Code::OK {
                self.checks.get_or_insert(answer.checked);
            }
            if self.checks == Some(true) && !answer.checked || answer.transport.is_of_lines() {
                return Err(Trouble::Garbled);
            }
            return match (answer.transport, answer.code) {
                (Code::OK, Code::OK) => Ok(answer),
                (Code::OK, code) | (code, _) => Err(Trouble::Refused(code)),
            };
        }
        Err(Trouble::Silent)
    }
}

fn face_of(number: Option<f64>) -> Result<Face, Trouble> {
    match number {
        Some(0.0) => Ok(Face::One),
        Some(1.0) => Ok(Face::Two),
        _ => Err(Trouble::Garbled),
    }
}
