//! What a program has done: moves, rests, and the words that may lift a pen.

use super::notes::Notes;
use crate::drawing::{Height, Piece};
use std::fmt;

/// The most values of S that are kept of a word that may lift a pen.
const MOST_VALUES: usize = 1000;

/// What the program has done.
pub struct Done {
    pub steps: Vec<Step>,
    pub said: Said,
    pub notes: Notes,
    pub warnings: Vec<String>,
}

/// The values of S beside words that may lift a pen, in the order in which they came first.
#[derive(Debug, Default)]
pub struct Said {
    spindle: Vec<f64>,
    servo: Vec<f64>,
    tone: Vec<f64>,
    /// What was in force at the first move over the plate, and at the end.
    pub first_move: Option<Signals>,
    pub end: Signals,
    /// The spindle's S was said without M3, too: it is a power or a speed.
    pub spindle_alone: bool,
    /// The first line of M280 and of M300, from 0.
    pub servo_line: Option<usize>,
    pub tone_line: Option<usize>,
}

impl Said {
    /// The values of a signal.
    pub fn of(&self, signal: Signal) -> &[f64] {
        match signal {
            Signal::Spindle => &self.spindle,
            Signal::Servo => &self.servo,
            Signal::Tone => &self.tone,
        }
    }

    pub fn add(&mut self, signal: Signal, value: f64) {
        let values = match signal {
            Signal::Spindle => &mut self.spindle,
            Signal::Servo => &mut self.servo,
            Signal::Tone => &mut self.tone,
        };
        if values.len() < MOST_VALUES && !values.contains(&value) {
            values.push(value);
        }
    }
}

/// How a move was commanded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pace {
    /// G0.
    Rapid,
    /// A rapid move of a cycle, in the hole that it has made.
    Withdrawal,
    /// Any other.
    Feed,
}

/// A move of the tool, or a rest.
#[derive(Clone, Debug)]
pub enum Step {
    Move(Move),
    /// G4, or at the bottom of a hole \[s\], with the words that may lift a pen.
    Dwell(f64, Signals),
}

/// A move.
#[derive(Clone, Debug)]
pub struct Move {
    pub pieces: Vec<(Piece, Height)>,
    pub pace: Pace,
    /// Feed [mm/s], if the program has said one.
    pub feed: Option<f64>,
    /// Whether spindle or laser were on.
    pub on: bool,
    /// The words that may lift a pen.
    pub signals: Signals,
    /// Whether the program has said any Z yet.
    pub z_said: bool,
    /// Its line, from 0.
    pub line: usize,
}

/// A word whose S lifts a pen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Signal {
    /// M3 or M4; M5 and S0 are up unless a value says otherwise.
    Spindle,
    /// M280.
    Servo,
    /// M300.
    Tone,
}

impl fmt::Display for Signal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Spindle => "M3",
            Self::Servo => "M280",
            Self::Tone => "M300",
        })
    }
}

/// The values of S that were in force at a move, once they were said.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Signals {
    /// Beside M3 or M4.
    pub spindle: Option<f64>,
    pub servo: Option<f64>,
    pub tone: Option<f64>,
}

impl Signals {
    /// The value of a signal.
    pub fn of(&self, signal: Signal) -> Option<f64> {
        match signal {
            Signal::Spindle => self.spindle,
            Signal::Servo => self.servo,
            Signal::Tone => self.tone,
        }
    }
}
