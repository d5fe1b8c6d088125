//! What a picture of a running cell shows beside its robots' joints: what they carry, their inputs and outputs, readings, bodies.
//!
//! In: one of these, or the words of a line that says it. Out: the words, or the same again. Numbers have an exponent: however small
//! one is, it takes at most 24 bytes.

use core::fmt;
use core::str::{FromStr, SplitAsciiWhitespace};

use mrroc_core::payload::{WORDS, Wire};
use mrroc_core::pose::Pose;
use mrroc_core::robot::{ANALOG, Load, Signals, Values};

/// What a robot carries, and its inputs and outputs.
#[derive(Clone, Debug, PartialEq)]
pub struct CarriedPicture {
    /// The robot.
    pub robot: String,
    /// The tool in force, `X_FE` \[m\].
    pub tool: Pose,
    /// What its drives were told last that the flange carries; `None`: they were told nothing.
    pub load: Option<Load>,
    /// What its inputs read, and what its outputs are.
    pub signals: Signals,
}

/// The newest reading of a virtual sensor.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ReadingPicture {
    /// The sensor.
    pub sensor: String,
    /// The step in which it was taken.
    pub step: u64,
    /// The words of the reading, at most [`WORDS`]; `None`: there was a fault instead.
    pub words: Option<Vec<u64>>,
}

/// Where a body is that the robots handle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BodyPicture {
    /// Its place among the bodies of the cell's layout.
    pub place: usize,
    /// Its pose in the world, `X_WB` \[m\].
    pub pose: Pose,
}

impl fmt::Display for CarriedPicture {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "carries {}", self.robot)?;
        put(f, &self.tool)?;
        match &self.load {
            Some(load) => {
                f.write_str(" load")?;
                put(f, load)?;
            }
            None => f.write_str(" nothing")?,
        }
        for values in [&self.signals.inputs, &self.signals.outputs] {
            write!(f, " {}", values.digital())?;
            (0..ANALOG as u8).try_for_each(|i| write!(f, " {:e}", values.analog(i)))?;
        }
        Ok(())
    }
}

impl CarriedPicture {
    /// Reads the words of a line that follow the first one.
    pub(super) fn take(words: &mut SplitAsciiWhitespace<'_>) -> Option<CarriedPicture> {
        let robot = words.next()?.to_owned();
        let tool = get(words)?;
        let load = match words.next()? {
            "load" => Some(get(words)?),
            "nothing" => None,
            _ => return None,
        };
        let mut values = || {
            let (digital, mut analog) = (number(words)?, [0.0; ANALOG]);
            for value in &mut analog {
                *value = number(words)?;
            }
            Some(Values::new(digital, analog))
        };
        Some(CarriedPicture { robot, tool, load, signals: Signals { inputs: values()?, outputs: values()? } })
    }
}

impl fmt::Display for ReadingPicture {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "reading {} {}", self.sensor, self.step)?;
        match &self.words {
            Some(words) => words.iter().try_for_each(|word| write!(f, " {word}")),
            None => f.write_str(" fault"),
        }
    }
}

impl ReadingPicture {
    /// Reads the words of a line that follow the first one.
    pub(super) fn take(words: &mut SplitAsciiWhitespace<'_>) -> Option<ReadingPicture> {
        let (sensor, step) = (words.next()?.to_owned(), number(words)?);
        let mut shown = Vec::new();
        for word in words.by_ref() {
            if word == "fault" && shown.is_empty() {
                return Some(ReadingPicture { sensor, step, words: None });
            }
            shown.push(word.parse().ok()?);
        }
        (shown.len() <= WORDS).then_some(ReadingPicture { sensor, step, words: Some(shown) })
    }
}

impl fmt::Display for BodyPicture {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "body {}", self.place)?;
        put(f, &self.pose)
    }
}

impl BodyPicture {
    /// Reads the words of a line that follow the first one.
    pub(super) fn take(words: &mut SplitAsciiWhitespace<'_>) -> Option<BodyPicture> {
        Some(BodyPicture { place: number(words)?, pose: get(words)? })
    }
}

/// The most words of what is written as numbers.
const NUMBERS: usize = 16;
const _: () = assert!(Pose::LEN <= NUMBERS && Load::LEN <= NUMBERS);

/// Writes what consists of numbers.
fn put<T: Wire>(f: &mut fmt::Formatter<'_>, value: &T) -> fmt::Result {
    let mut words = [0; NUMBERS];
    value.put(&mut words);
    words[..T::LEN].iter().try_for_each(|word| write!(f, " {:e}", f64::from_bits(*word)))
}

/// Reads the next word, a number.
pub(super) fn number<T: FromStr>(words: &mut SplitAsciiWhitespace<'_>) -> Option<T> {
    words.next()?.parse().ok()
}

/// Reads what consists of numbers.
fn get<T: Wire>(words: &mut SplitAsciiWhitespace<'_>) -> Option<T> {
    let mut numbers = [0; NUMBERS];
    for word in &mut numbers[..T::LEN] {
        *word = number::<f64>(words)?.to_bits();
    }
    T::get(&numbers).ok()
}
