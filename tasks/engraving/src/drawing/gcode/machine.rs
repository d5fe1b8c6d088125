//! The machine that runs blocks: position, modes, and the moves that come out.

use super::arc::{self, Circle};
use super::block::{Block, Word};
use super::cutting::{self, Pace, PlaneMove};
use super::modes::{Distance, MachineWord, Modes, Motion, Plane, Request};
use super::parameters::Parameters;
use super::spline::{self, Collected};
use super::{Cause, Stop, malformed, unsupported};
use crate::drawing::{Budget, Drawing, Import, Piece, Vec2};

/// Whether the program goes on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Flow {
    /// To the next line.
    Continue,
    /// M2 or M30.
    End,
}

/// The machine's state.
pub struct Machine<'a> {
    budget: &'a mut Budget,
    parameters: Parameters,
    modes: Modes,
    tool: Vec2,
    z: f64,
    moves: Vec<PlaneMove>,
    nurbs: Option<Collected>,
    /// The tangent with which the last G5 arrived.
    tangent: Option<Vec2>,
    warnings: Vec<String>,
    line: usize,
}

impl<'a> Machine<'a> {
    /// A machine at the origin, 1 mm above the plate.
    pub fn new(budget: &'a mut Budget) -> Self {
        Self {
            budget,
            parameters: Parameters::default(),
            modes: Modes::default(),
            tool: Vec2::zeros(),
            z: 1.0,
            moves: Vec::new(),
            nurbs: None,
            tangent: None,
            warnings: Vec::new(),
            line: 0,
        }
    }

    /// The parameters, for reading a line.
    pub fn parameters(&mut self) -> &mut Parameters {
        &mut self.parameters
    }

    /// Runs one line, which may be empty.
    pub fn run(&mut self, block: &Block) -> Result<Flow, Stop> {
        self.line += 1;
        check_letters(block)?;
        if let Some(feed) = block.word('f')
            && feed.value <= 0.0
        {
            return Err(Stop { byte: feed.byte, cause: Cause::Feed(feed.value) });
        }
        if let Some(power) = block.value('s') {
            self.modes.power = Some(power);
        }
        let mut flow = Flow::Continue;
        for word in block.words.iter().filter(|w| w.letter == 'm') {
            match self.modes.m(word.value.floor() as i64, word.byte)? {
                Some(MachineWord::End) => flow = Flow::End,
                Some(MachineWord::LeftOut(what)) => self.left_out('M', word, what),
                None => {}
            }
        }
        let mut moves = true;
        for word in block.words.iter().filter(|w| w.letter == 'g') {
            match self.modes.g((word.value * 10.0).round() as i64, word.byte)? {
                Request::Nothing => {}
                Request::NoMotion => moves = false,
                Request::Home => {
                    self.left_out('G', word, "the way home");
                    self.travel_home();
                    moves = false;
                }
                Request::EndNurbs => {
                    self.end_nurbs(word.byte)?;
                    moves = false;
                }
                Request::LeftOut(what) => self.left_out('G', word, what),
            }
        }
        if moves {
            self.motion(block)?;
        }
        Ok(flow)
    }

    /// The strokes of the whole program.
    pub fn finish(self) -> Result<Import, Stop> {
        if self.nurbs.is_some() {
            return Err(Stop { byte: 0, cause: Cause::Truncated("between G5.2 and G5.3".to_owned()) });
        }
        let mut warnings = self.warnings;
        if self.modes.mm_per_unit.is_none() && !self.moves.is_empty() {
            warnings.push("neither G20 nor G21 in the program: millimetres are assumed".to_owned());
        }
        Ok(Import { drawing: Drawing { strokes: cutting::strokes(self.moves)? }, warnings })
    }

    fn left_out(&mut self, letter: char, word: &Word, what: &str) {
        let name = format!("{letter}{}", word.value);
        if !self.warnings.iter().any(|w| w.contains(&format!(": {name} left out"))) {
            self.warnings.push(format!("line {}: {name} left out: {what}", self.line));
        }
    }

    fn travel_home(&mut self) {
        // The next stroke does not begin where the last one ended: an empty travel says so.
        self.moves.push(PlaneMove {
            pieces: Vec::new(),
            pace: Pace::Rapid,
            deep: false,
            on: false,
            line: self.line,
        });
        self.z = self.z.max(1.0);
    }

    fn scale(&self) -> f64 {
        self.modes.mm_per_unit.unwrap_or(1.0)
    }

    fn motion(&mut self, block: &Block) -> Result<(), Stop> {
        let Some(first) = block.words.iter().find(|w| matches!(w.letter, 'x' | 'y' | 'z' | 'i' | 'j')) else {
            return Ok(());
        };
        let scale = self.scale();
        let to = |letter: char, now: f64| match block.word(letter) {
            None => Ok(now),
            Some(word) => {
                let mm =
                    word.value * scale + if self.modes.distance == Distance::Relative { now } else { 0.0 };
                if mm.abs() < 1e7 {
                    Ok(mm)
                } else {
                    let what = letter.to_ascii_uppercase().to_string();
                    Err(Stop { byte: word.byte, cause: Cause::Range(what, mm) })
                }
            }
        };
        let end = Vec2::new(to('x', self.tool.x)?, to('y', self.tool.y)?);
        let z = to('z', self.z)?;
        let pieces = self.pieces(block, end, first.byte)?;
        if let Motion::Nurbs = self.modes.motion {
            self.tool = end;
            return Ok(());
        }
        self.push(pieces, z)?;
        self.tool = end;
        self.z = z;
        Ok(())
    }

    fn pieces(&mut self, block: &Block, to: Vec2, byte: usize) -> Result<Vec<Piece>, Stop> {
        let scale = self.scale();
        let pair = |a, b| match (block.value(a), block.value(b)) {
            (None, None) => None,
            (x, y) => Some(Vec2::new(x.unwrap_or(0.0), y.unwrap_or(0.0)) * scale),
        };
        let tangent = self.tangent.take();
        if self.nurbs.is_some() && self.modes.motion != Motion::Nurbs {
            return malformed(byte, "a move between G5.2 and G5.3", "end the spline by G5.3 first");
        }
        let piece = match self.modes.motion {
            Motion::Rapid | Motion::Line => Piece::Line { from: self.tool, to },
            Motion::Clockwise | Motion::CounterClockwise => {
                let counter = self.modes.motion == Motion::CounterClockwise;
                self.arc(block, to, pair('i', 'j'), counter, byte)?
            }
            Motion::Cubic => {
                let Some(arrive) = pair('p', 'q') else {
                    return malformed(byte, "G5 without P and Q", "give the end's control point by P and Q");
                };
                self.tangent = Some(-arrive);
                spline::cubic(self.tool, to, pair('i', 'j'), arrive, tangent, byte)?
            }
            Motion::Quadratic => match pair('i', 'j') {
                Some(control) => Piece::quadratic(self.tool, self.tool + control, to),
                None => return malformed(byte, "G5.1 without I and J", "give the control point by I and J"),
            },
            Motion::Nurbs => {
                let collected = match self.nurbs.take() {
                    Some(collected) => collected,
                    None => Collected::new(self.tool, block.word('l'), byte)?,
                };
                self.nurbs.insert(collected).add(to, block)?;
                self.take_budget(1)?;
                return Ok(Vec::new());
            }
            Motion::None => {
                return malformed(
                    byte,
                    "coordinates before any G0, G1, G2 or G3",
                    "begin the line with a motion word",
                );
            }
        };
        Ok(vec![piece])
    }

    fn arc(
        &self,
        block: &Block,
        to: Vec2,
        ij: Option<Vec2>,
        counter: bool,
        byte: usize,
    ) -> Result<Piece, Stop> {
        if self.modes.plane != Plane::Xy {
            return unsupported(
                byte,
                "an arc in the plane G18 or G19",
                "arcs on the plate need G17; write others as G1 moves",
            );
        }
        if let Some(turns) = block.word('p')
            && turns.value != 1.0
        {
            return unsupported(turns.byte, "an arc of several turns", "write one arc for each turn");
        }
        let circle = match (ij, block.value('r')) {
            (Some(_), Some(_)) => {
                return malformed(byte, "an arc with a centre and a radius", "give I and J, or R");
            }
            (None, None) => return malformed(byte, "an arc without centre or radius", "give I and J, or R"),
            (None, Some(r)) => Circle::Radius(r * self.scale()),
            (Some(ij), None) => Circle::Centre(match self.modes.centres {
                Distance::Relative => self.tool + ij,
                Distance::Absolute => ij,
            }),
        };
        arc::piece(self.tool, to, circle, counter, byte)
    }

    fn end_nurbs(&mut self, byte: usize) -> Result<(), Stop> {
        match self.nurbs.take() {
            None => malformed(byte, "G5.3 without G5.2", "begin the spline by G5.2"),
            Some(collected) => {
                self.modes.motion = Motion::None;
                let pieces = collected.pieces()?;
                self.push(pieces, self.z)
            }
        }
    }

    fn push(&mut self, pieces: Vec<Piece>, z: f64) -> Result<(), Stop> {
        let moved = pieces.iter().any(|piece| !matches!(piece, Piece::Line { from, to } if from == to));
        if !moved {
            return Ok(());
        }
        self.take_budget(pieces.len())?;
        let pace = if self.modes.motion == Motion::Rapid { Pace::Rapid } else { Pace::Feed };
        // A ramp cuts from where it enters; a rapid is in the plate only if it stays there.
        let deep = match pace {
            Pace::Feed => self.z.min(z) < -1e-9,
            Pace::Rapid => self.z.max(z) < -1e-9,
        };
        self.moves.push(PlaneMove { pieces, pace, deep, on: self.modes.is_on(), line: self.line });
        Ok(())
    }

    fn take_budget(&mut self, count: usize) -> Result<(), Stop> {
        let limit = self.budget.limits().pieces;
        self.budget
            .take(count, crate::error::Place::default)
            .map_err(|_| Stop { byte: 0, cause: Cause::TooMany(limit) })
    }
}

/// Letters that mean something here; others would change what the program does.
fn check_letters(block: &Block) -> Result<(), Stop> {
    for word in &block.words {
        let letter = word.letter.to_ascii_uppercase();
        match word.letter {
            'd' | 'f' | 'g' | 'h' | 'i' | 'j' | 'k' | 'l' | 'm' | 'p' | 'q' | 'r' | 's' | 't' | 'x' | 'y'
            | 'z' => {}
            'e' => {
                return unsupported(
                    word.byte,
                    "an E word: a program for a 3-D printer",
                    "export it for a mill, a plotter or a laser",
                );
            }
            'a' | 'b' | 'c' | 'u' | 'v' | 'w' => {
                return unsupported(word.byte, format!("axis {letter}"), "export the program for three axes");
            }
            _ => {
                return malformed(
                    word.byte,
                    format!("no word begins with {letter}"),
                    "check that the file is RS-274 G-code",
                );
            }
        }
    }
    Ok(())
}
