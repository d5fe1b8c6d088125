//! G-code (RS-274/NGC): the cutting moves of a program become strokes, with their depths and feeds.
//!
//! The interpreter knows lines, arcs in all planes, splines, cycles for holes, units, distance modes, coordinate
//! systems, polar words, parameters `#n` and `#<name>`, expressions in brackets, and O-words: subroutines, loops and
//! conditions (NIST RS274/NGC and LinuxCNC's manual; G6.2 by Fanuc's). What would change the drawing and is not
//! understood is refused; what does not matter on this machine (coolant, tool changes) is left out with a warning, and
//! so is a word that says nothing in its line.
//!
//! The plate's surface is the machine's Z0, where all coordinate systems lie until the program moves them. Which moves
//! cut is decided once for the whole program:
//! 1. a feed move somewhere below Z0: of every feed move the part that is below Z0 is cut, as deep as its Z says;
//! 2. else, a pen that M280, M300 or the S of M3 lifts ([`PenLift`]): feed moves with the pen down;
//! 3. else, feed moves at Z0 (or before any Z) after M3 or M4 (before M5, and power not S0): only such moves cut;
//! 4. else: every feed move at Z0 (or before any Z) cuts.
//!
//! Above Z0 nothing is cut. G0 is travel in each of them, and refused where it would drag the tool below Z0.

mod arc;
mod block;
mod characters;
mod coordinates;
mod cutting;
mod cycles;
mod data;
mod expression;
mod flow;
mod machine;
mod modes;
mod motion;
mod notes;
mod o_word;
mod parameters;
mod pen;
mod program;
mod spline;
mod steps;
mod stop;

use super::{Budget, Drawing, Import, Order};
use crate::error::{DrawingError, Place};
use characters::Characters;
pub use cutting::DEEPEST;
use cutting::cuts;
use flow::Control;
use machine::{ControlRequest, Machine};
pub use pen::PenLift;
pub use program::BlockDelete;
use program::Program;
pub use steps::Signal;
use stop::{Cause, Stop};

/// What is chosen for a program before it is read.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Switches {
    /// Whether lines that begin with `/` run.
    pub block_delete: BlockDelete,
    /// The Z of the program that is the plate's surface \[mm\].
    pub surface: f64,
    /// What lifts the pen of a plotter's program.
    pub pen: PenLift,
}

/// Reads an RS-274 program.
///
/// # Errors
/// [`DrawingError`] at the line and column that cannot be engraved.
pub fn read(file: &str, text: &str, switches: Switches, budget: &mut Budget) -> Result<Import, DrawingError> {
    interpret(text, switches, budget).map_err(|stop| {
        let last = text.lines().count().saturating_sub(1);
        let number = stop.line.unwrap_or(last);
        let line = text.lines().nth(number).unwrap_or("");
        let at = match stop.byte {
            0 => Place::line(file, number + 1, line),
            byte => {
                let column = line.char_indices().take_while(|(at, _)| *at < byte).count() + 1;
                Place::column(file, number + 1, column, line)
            }
        };
        match stop.cause {
            Cause::Nothing(found) => DrawingError::Empty {
                file: file.to_owned(),
                found,
                help: "a cut is below Z0, the plate's surface; --surface says at which Z of the file it lies"
                    .to_owned(),
            },
            Cause::NoPen(found) => DrawingError::Empty {
                file: file.to_owned(),
                found,
                help: "leave --pen out, or say what lifts the pen: z, m3, m280 or m300".to_owned(),
            },
            cause => cause.at(at),
        }
    })
}

fn interpret(text: &str, switches: Switches, budget: &mut Budget) -> Result<Import, Stop> {
    let depth = budget.limits().depth;
    let program = Program::new(text, switches.block_delete, depth)?;
    let mut control = Control::new(&program, depth);
    let mut machine = Machine::new(budget, switches.surface);
    while let Some((number, line)) = control.next()? {
        if matches!(line.trim(), "" | "%") || switches.block_delete.deletes(line) {
            continue;
        }
        let ended = one_line(number, line, &program, &mut control, &mut machine, depth);
        if ended.map_err(|stop| stop.on(number))? {
            break;
        }
    }
    let done = machine.finish()?;
    let cuts = cuts(done, switches.pen)?;
    if let Some(found) = cuts.nothing {
        return Err(Stop { byte: 0, cause: Cause::Nothing(found), line: None });
    }
    let mut warnings = cuts.warnings;
    if program.deleted > 0 {
        let lines = if program.deleted == 1 { "line that begins" } else { "lines that begin" };
        warnings
            .push(format!("{} {lines} with / left out: --block-delete off runs such lines", program.deleted));
    }
    Ok(Import { drawing: Drawing { strokes: cuts.strokes }, warnings, order: Order::AsGiven })
}

/// Runs one line; `true` at the end of the program.
fn one_line(
    number: usize,
    line: &str,
    program: &Program<'_>,
    control: &mut Control<'_>,
    machine: &mut Machine<'_>,
    depth: usize,
) -> Result<bool, Stop> {
    let mut characters = Characters::new(line);
    characters.accept('/');
    if let Some(word) = program.word(number) {
        control.carry_out(number, line, word, machine.parameters(line))?;
        if word.flow != program::Flow::Number {
            return Ok(false);
        }
        // Behind the number of a program, words may stand.
        characters.skip_to(word.rest);
    }
    let block = block::parse(&mut characters, machine.parameters(line), depth)?;
    match machine.run(number, &block)? {
        ControlRequest::Nothing => Ok(false),
        ControlRequest::End => Ok(true),
        ControlRequest::Call { number, times, byte } => {
            control.run_numbered(number, times, byte).map(|()| false)
        }
        ControlRequest::Return { byte } => Ok(!control.return_numbered(byte)?),
    }
}

#[cfg(test)]
mod tests;
