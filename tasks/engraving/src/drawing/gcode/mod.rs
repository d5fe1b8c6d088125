//! G-code (RS-274/NGC): the cutting moves of a program become strokes.
//!
//! The interpreter knows G0 to G3, G5 to G5.3, planes, units, distance modes, parameters `#n` and `#<name>`, and
//! expressions in brackets (NIST RS274/NGC, sections 3.3 to 3.6). Anything that would change the drawing and is not
//! understood is refused; what does not matter on this machine (coolant, tool changes) is left out with a warning.
//!
//! Which moves cut is decided once for the whole program:
//! 1. a feed move somewhere at Z below 0: feed moves with an end below Z0 cut;
//! 2. else, a feed move somewhere after M3 or M4 (before M5, and power not S0): only such feed moves cut;
//! 3. else: every feed move cuts.
//!
//! G0 is travel in each of them, and refused where it would drag the tool below Z0.

mod arc;
mod block;
mod characters;
mod cutting;
mod expression;
mod machine;
mod modes;
mod parameters;
mod spline;

use super::{Budget, Import};
use crate::error::{DrawingError, Place};
use characters::Characters;
use machine::{Flow, Machine};

/// Reads an RS-274 program.
///
/// # Errors
/// [`DrawingError`] at the line and column that cannot be engraved.
pub fn read(file: &str, text: &str, budget: &mut Budget) -> Result<Import, DrawingError> {
    let depth = budget.limits().depth;
    let mut machine = Machine::new(budget);
    let mut percent_signs = 0;
    for (i, line) in text.lines().enumerate() {
        if line.trim() == "%" {
            percent_signs += 1;
            if percent_signs == 2 {
                break;
            }
            continue;
        }
        let mut characters = Characters::new(line);
        let ran =
            block::parse(&mut characters, machine.parameters(), depth).and_then(|block| machine.run(&block));
        match ran {
            Ok(Flow::Continue) => {}
            Ok(Flow::End) => break,
            Err(stop) => {
                let column = line.char_indices().take_while(|(at, _)| *at < stop.byte).count() + 1;
                return Err(stop.cause.at(Place::column(file, i + 1, column, line)));
            }
        }
    }
    machine.finish().map_err(|stop| {
        let last = text.lines().count().max(1);
        stop.cause.at(Place::line(file, last, text.lines().last().unwrap_or("")))
    })
}

/// Why a block stops the reading, and at which byte of its line.
#[derive(Debug)]
struct Stop {
    byte: usize,
    cause: Cause,
}

/// A cause that does not know its place yet.
#[derive(Debug)]
enum Cause {
    Malformed(String, String),
    Unsupported(String, String),
    Truncated(String),
    Feed(f64),
    Mismatch(f64, f64),
    Range(String, f64),
    TooMany(usize),
    TooDeep(usize),
}

impl Cause {
    fn at(self, at: Place) -> DrawingError {
        match self {
            Self::Malformed(what, help) => DrawingError::Malformed { at, what, help },
            Self::Unsupported(what, help) => DrawingError::Unsupported { at, what, help },
            Self::Truncated(inside) => DrawingError::Truncated { at, inside },
            Self::Feed(feed) => DrawingError::FeedNotPositive { at, feed },
            Self::Mismatch(start_mm, end_mm) => DrawingError::ArcMismatch { at, start_mm, end_mm },
            Self::Range(what, value) => DrawingError::OutOfRange { at, what, value },
            Self::TooMany(limit) => DrawingError::TooManyPieces { at, limit },
            Self::TooDeep(limit) => DrawingError::TooDeep { at, what: "brackets", limit },
        }
    }
}

fn malformed<T>(byte: usize, what: impl Into<String>, help: impl Into<String>) -> Result<T, Stop> {
    Err(Stop { byte, cause: Cause::Malformed(what.into(), help.into()) })
}

fn unsupported<T>(byte: usize, what: impl Into<String>, help: impl Into<String>) -> Result<T, Stop> {
    Err(Stop { byte, cause: Cause::Unsupported(what.into(), help.into()) })
}

#[cfg(test)]
mod tests;
