//! Where the program goes on: conditions, loops, subroutines, and the numbered programs of M98 and M99.
//!
//! Every line that runs has its cost; together they may cost what all lines of the file do and [`ALLOWANCE`] more, so that
//! a loop without an end is refused within two seconds.

use super::block;
use super::characters::Characters;
use super::expression::Values;
use super::o_word::Label;
use super::parameters::Parameters;
use super::program::{Cursor, Flow, OWord, Program};
use super::stop::{Stop, malformed};

/// What lines that run again may cost \[bytes\].
const ALLOWANCE: usize = 64 << 20;
/// The most arguments of a call.
const MOST_ARGUMENTS: usize = 30;

/// A subroutine or numbered program that was called.
struct Frame {
    /// Where the caller goes on.
    back: Cursor,
    /// The numbered program that runs, and how often it is still to run after this time.
    numbered: Option<(usize, u64)>,
    /// Loops of the caller that count.
    repeats: Vec<(usize, u64)>,
}

/// Where a program is.
pub struct Control<'a> {
    program: &'a Program<'a>,
    pub cursor: Cursor,
    frames: Vec<Frame>,
    /// `repeat` lines that run, and how often each is still to run after this time.
    repeats: Vec<(usize, u64)>,
    left: usize,
    depth: usize,
}

impl<'a> Control<'a> {
    /// At the first line; calls may be so deep.
    pub fn new(program: &'a Program<'a>, depth: usize) -> Self {
        let left = program.cost.saturating_add(ALLOWANCE);
        let cursor = Program::begin();
        Self { program, cursor, frames: Vec::new(), repeats: Vec::new(), left, depth }
    }

    /// The number and the text of the next line.
    pub fn next(&mut self) -> Result<Option<(usize, &'a str)>, Stop> {
        let before = self.cursor;
        let Some((number, line)) = self.program.next(&mut self.cursor) else { return Ok(None) };
        match self.left.checked_sub(self.cursor.cost_since(before)) {
            Some(left) => self.left = left,
            None => {
                let what = "a program that goes on and on: its loops do not end within a million lines";
                let help = "check the conditions of its loops";
                return malformed(0, what, help).map_err(|stop: Stop| stop.on(number));
            }
        }
        Ok(Some((number, line)))
    }

    /// Carries out the O-word of a line.
    pub fn carry_out(
        &mut self,
        number: usize,
        line: &str,
        word: &OWord,
        parameters: &mut Parameters,
    ) -> Result<(), Stop> {
        let depth = self.depth;
        let mut at = Characters::new(line);
        at.skip_to(word.rest);
        let at = &mut at;
        match word.flow {
            // Words beside the number of a program are not its business.
            Flow::Number => return Ok(()),
            Flow::EndIf | Flow::Do => {}
            Flow::Sub { end } => self.cursor = self.program.after(end),
            Flow::EndSub | Flow::Return => {
                let value = match at.peek() {
                    Some('[') => Some(bracketed(at, parameters, depth)?),
                    _ => None,
                };
                self.leave(value, word, parameters)?;
            }
            Flow::Call => {
                let label = match &word.label {
                    Label::Computed => {
                        let mut behind = Characters::new(line);
                        behind.skip_to(word.byte);
                        behind.take();
                        computed(&mut behind, parameters, depth)?
                    }
                    label => label.clone(),
                };
                let arguments = arguments(at, parameters, depth)?;
                self.call(&label, &arguments, word.byte, parameters)?;
            }
            Flow::If { next } => {
                if !condition(at, parameters, depth)? {
                    self.branch(next, parameters)?;
                }
            }
            // Reached from above: the branch before it was taken.
            Flow::ElseIf { end, .. } | Flow::Else { end } => {
                self.cursor = self.program.after(end);
                return Ok(());
            }
            Flow::While { end } => {
                if !condition(at, parameters, depth)? {
                    self.cursor = self.program.after(end);
                }
            }
            Flow::EndWhile { start } => self.cursor = self.program.at(start),
            Flow::DoWhile { start } => {
                if condition(at, parameters, depth)? {
                    self.cursor = self.program.after(start);
                }
            }
            Flow::Repeat { end } => {
                let times = bracketed(at, parameters, depth)?.round();
                self.repeats.retain(|(line, _)| *line != number);
                if times >= 1.0 {
                    self.repeats.push((number, times as u64 - 1));
                } else {
                    self.cursor = self.program.after(end);
                }
            }
            Flow::EndRepeat { start } => self.again(start),
            Flow::Break { start, end } => {
                self.repeats.retain(|(line, _)| !(start..=end).contains(line));
                self.cursor = self.program.after(end);
            }
            Flow::Continue { start, end } => {
                self.repeats.retain(|(line, _)| !(start + 1..=end).contains(line));
                self.cursor = self.program.at(end);
            }
        }
        end(at)
    }

    fn again(&mut self, start: usize) {
        if let Some((line, left)) = self.repeats.last_mut()
            && *line == start
        {
            if *left > 0 {
                *left -= 1;
                self.cursor = self.program.after(start);
            } else {
                self.repeats.pop();
            }
        }
    }

    /// Looks for the first branch from a line on whose condition holds.
    fn branch(&mut self, from: usize, parameters: &Parameters) -> Result<(), Stop> {
        let mut line = from;
        while let Some(word) = self.program.word(line)
            && let Flow::ElseIf { next, .. } = word.flow
        {
            self.cursor = self.program.at(line);
            let Some((number, text)) = self.next()? else { break };
            let mut at = Characters::new(text);
            at.skip_to(word.rest);
            if condition(&mut at, parameters, self.depth).map_err(|stop| stop.on(number))? {
                return Ok(());
            }
            line = next;
        }
        self.cursor = self.program.after(line);
        Ok(())
    }

    fn call(
        &mut self,
        label: &Label,
        arguments: &[f64],
        byte: usize,
        parameters: &mut Parameters,
    ) -> Result<(), Stop> {
        let Some(start) = self.program.subs.get(label) else {
            let name = match label {
                Label::Number(n) => format!("o{n}"),
                Label::Name(name) => format!("o<{name}>"),
                Label::Computed => "o[..]".to_owned(),
            };
            let help = "define it by sub and endsub in this file: other files are not read";
            return malformed(byte, format!("a call of {name}, which is no subroutine of this file"), help);
        };
        self.push(byte, None)?;
        parameters.enter(arguments);
        self.cursor = self.program.after(*start);
        Ok(())
    }

    fn push(&mut self, byte: usize, numbered: Option<(usize, u64)>) -> Result<(), Stop> {
        if self.frames.len() >= self.depth {
            return Err(Stop::too_deep(byte, "calls", self.depth));
        }
        self.frames.push(Frame { back: self.cursor, numbered, repeats: std::mem::take(&mut self.repeats) });
        Ok(())
    }

    fn leave(&mut self, value: Option<f64>, word: &OWord, parameters: &mut Parameters) -> Result<(), Stop> {
        match self.frames.pop() {
            Some(Frame { back, numbered: None, repeats }) => {
                parameters.leave(value);
                self.cursor = back;
                self.repeats = repeats;
                Ok(())
            }
            _ => malformed(word.byte, "the end of a subroutine that was not called", "call it by o.. call"),
        }
    }

    /// M98: runs a numbered program so many times.
    pub fn run_numbered(&mut self, number: f64, times: f64, byte: usize) -> Result<(), Stop> {
        let found = if number.fract() == 0.0 && (0.0..1e9).contains(&number) {
            self.program.numbers.get(&(number as u32)).copied()
        } else {
            None
        };
        let Some(start) = found else {
            let help = "the program O.. with this number must stand in the same file";
            return malformed(byte, format!("M98 P{number}: no such program in this file"), help);
        };
        if !(0.0..=1e9).contains(&times) || times.fract() != 0.0 {
            return malformed(byte, format!("M98 L{times}"), "L is a whole number of times");
        }
        if times >= 1.0 {
            self.push(byte, Some((start, times as u64 - 1)))?;
            self.cursor = self.program.after(start);
        }
        Ok(())
    }

    /// M99: back to the caller of a numbered program, or around once more; `false` in the main program.
    pub fn return_numbered(&mut self, byte: usize) -> Result<bool, Stop> {
        match self.frames.last_mut() {
            None => Ok(false),
            Some(Frame { numbered: Some((start, left)), .. }) if *left > 0 => {
                *left -= 1;
                self.cursor = self.program.after(*start);
                self.repeats.clear();
                Ok(true)
            }
            Some(Frame { numbered: Some(_), .. }) => {
                if let Some(frame) = self.frames.pop() {
                    self.cursor = frame.back;
                    self.repeats = frame.repeats;
                }
                Ok(true)
            }
            Some(Frame { numbered: None, .. }) => {
                malformed(byte, "M99 in a subroutine of O-words", "end it by o.. return or o.. endsub")
            }
        }
    }
}

/// The value of what is in brackets after an O-word.
fn bracketed(at: &mut Characters<'_>, parameters: &Parameters, depth: usize) -> Result<f64, Stop> {
    Values { line: at, parameters, depth, limit: depth }.bracketed()
}

/// Whether the condition in brackets holds: it is not 0.
fn condition(at: &mut Characters<'_>, parameters: &Parameters, depth: usize) -> Result<bool, Stop> {
    Ok(bracketed(at, parameters, depth)? != 0.0)
}

/// The arguments of a call, each in brackets.
fn arguments(at: &mut Characters<'_>, parameters: &Parameters, depth: usize) -> Result<Vec<f64>, Stop> {
    let mut arguments = Vec::new();
    while at.peek() == Some('[') {
        if arguments.len() == MOST_ARGUMENTS {
            return malformed(
                at.byte(),
                "more than 30 arguments",
                "pass the others by global parameters #<_name>",
            );
        }
        arguments.push(bracketed(at, parameters, depth)?);
    }
    Ok(arguments)
}

/// Nothing but comments may follow.
fn end(at: &mut Characters<'_>) -> Result<(), Stop> {
    loop {
        match at.peek() {
            None | Some(';') => return Ok(()),
            Some('(') => block::comment(at)?,
            Some(_) => {
                return malformed(at.byte(), "more than its values after an O-word", "begin a new line");
            }
        }
    }
}

/// The label that `o[..]` or `o#..` computes, behind the O.
fn computed(at: &mut Characters<'_>, parameters: &Parameters, depth: usize) -> Result<Label, Stop> {
    let byte = at.byte();
    let value = Values { line: at, parameters, depth, limit: depth }.value()?;
    if value.fract() == 0.0 && (0.0..1e9).contains(&value) {
        Ok(Label::Number(value as u32))
    } else {
        malformed(byte, format!("a label o{value}"), "labels are whole numbers")
    }
}
