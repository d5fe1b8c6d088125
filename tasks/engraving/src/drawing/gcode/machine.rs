//! The machine that runs blocks: position, modes, and the steps that come out.

use super::block::{Block, Word};
use super::coordinates::Coordinates;
use super::modes::{Distance, FeedMode, MachineWord, Modes, Plane, Request, Sticky, check_groups, tenths};
use super::notes::Notes;
use super::parameters::{MachineReport, Parameters};
use super::spline::Collected;
use super::steps::{Done, Move, Pace, Said, Signal, Signals, Step};
use super::stop::{Cause, Stop, malformed, unsupported};
use crate::drawing::{Budget, Height, Piece, Vec2, Vec3};

/// What a line asks of the program's control.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ControlRequest {
    /// To go on with the next line.
    Nothing,
    /// M2 or M30.
    End,
    /// M98: to run a numbered program so many times.
    Call { number: f64, times: f64, byte: usize },
    /// M99.
    Return { byte: usize },
}

/// The longest rest that is kept \[s\]: more is a program that counts milliseconds.
const LONGEST_DWELL: f64 = 60.0;

/// The machine's state. Places are machine coordinates \[mm\].
pub struct Machine<'a> {
    pub(super) budget: &'a mut Budget,
    pub(super) parameters: Parameters,
    pub(super) modes: Modes,
    pub(super) coordinates: Coordinates,
    pub(super) tool: Vec3,
    /// The Z that is the plate's surface.
    surface: f64,
    pub(super) z_said: bool,
    /// F as it was said, and what it is by the modes [mm/s].
    said_feed: f64,
    feed: Option<f64>,
    tool_number: f64,
    pub(super) homes: [Vec3; 2],
    steps: Vec<Step>,
    pub(super) nurbs: Option<Collected>,
    /// The tangent with which the last G5 arrived.
    pub(super) tangent: Option<Vec2>,
    pub(super) sticky: Sticky,
    /// The words that may lift a pen: the values in force, and all that were said.
    pub(super) signals: Signals,
    pub(super) said: Said,
    /// Which servo it is: P of the first M280.
    servo: Option<f64>,
    pub(super) notes: Notes,
    /// The line that runs, from 0.
    pub(super) line: usize,
}

impl<'a> Machine<'a> {
    /// A machine at its origin, where the plate's surface lies at Z `surface` \[mm\].
    pub fn new(budget: &'a mut Budget, surface: f64) -> Self {
        Self {
            budget,
            parameters: Parameters::default(),
            modes: Modes::default(),
            coordinates: Coordinates::default(),
            tool: Vec3::zeros(),
            surface,
            z_said: false,
            said_feed: 0.0,
            feed: None,
            tool_number: 0.0,
            homes: [Vec3::zeros(); 2],
            steps: Vec::new(),
            nurbs: None,
            tangent: None,
            sticky: Sticky::default(),
            signals: Signals::default(),
            said: Said::default(),
            servo: None,
            notes: Notes::default(),
            line: 0,
        }
    }

    /// The parameters, for reading a line: those that the machine keeps are brought up to date if it names any.
    pub fn parameters(&mut self, line: &str) -> &mut Parameters {
        if !line.contains('#') {
            return &mut self.parameters;
        }
        let scale = self.scale();
        let Coordinates { systems, active, .. } = self.coordinates;
        self.parameters.told = MachineReport {
            position: (self.tool - self.coordinates.origin()) / scale,
            machine: self.tool / scale,
            shift: self.coordinates.shift() / scale,
            systems: systems.map(|origin| origin / scale),
            active,
            mm_per_unit: scale,
            relative: self.modes.distance == Distance::Relative,
            feed: self.said_feed,
            speed: self.modes.power.unwrap_or(0.0),
            spindle_on: self.modes.beam_on,
            tool: self.tool_number,
            plane: match self.modes.plane {
                Plane::Xy => 170.0,
                Plane::Zx => 180.0,
                Plane::Yz => 190.0,
            },
            motion: self.modes.motion.tenths(),
        };
        &mut self.parameters
    }

    /// Runs the words of a line, which may be none.
    pub fn run(&mut self, line: usize, block: &Block) -> Result<ControlRequest, Stop> {
        self.line = line;
        check_letters(block)?;
        check_groups(block.all('g'))?;
        self.say_values(block);
        let asked = self.machine_words(block)?;
        let mut moves = true;
        let mut in_machine = false;
        let before = self.modes.motion;
        let mut requests = Vec::new();
        for word in block.all('g') {
            let request = self.modes.g(tenths(word), word.byte)?;
            requests.push((word.clone(), request));
        }
        self.change_of_motion(before, block)?;
        self.take_feed(block)?;
        for (word, request) in &requests {
            match *request {
                Request::Nothing => {}
                Request::Takes(letters) => block.take(letters),
                Request::LeftOut(what, letters) => {
                    block.take(letters);
                    moves &= !letters.contains('x');
                    self.left_out('G', word, what);
                }
                Request::Dwell => self.dwell(block, word.byte)?,
                Request::EndNurbs => {
                    self.end_nurbs(word.byte)?;
                    moves = false;
                }
                Request::MachineCoordinates => in_machine = true,
                Request::System(system) => self.coordinates.choose(system),
                Request::SetData
                | Request::Home(_)
                | Request::StoreHome(_)
                | Request::Shift
                | Request::ShiftHere
                | Request::ForgetShift
                | Request::PutShiftBy
                | Request::RestoreShift => {
                    self.set(*request, block, word.byte)?;
                    moves = false;
                }
            }
        }
        if moves {
            self.motion(block, in_machine)?;
        }
        self.tell_untaken(block);
        Ok(asked)
    }

    fn say_values(&mut self, block: &Block) {
        // Beside the word of another machine S is that word's own.
        let of_spindle =
            |word: &Word| matches!(word.value.floor() as i64, 0..=9 | 30 | 48..=60 | 98 | 99 | 106 | 107);
        if block.has("s")
            && block.all('m').all(of_spindle)
            && let Some(power) = block.value('s')
        {
            self.said.spindle_alone |= !block.has("m") && self.modes.power.is_some_and(|old| old != power);
            self.modes.power = Some(power);
        }
        if let Some(tool) = block.value('t') {
            self.tool_number = tool;
        }
    }

    fn machine_words(&mut self, block: &Block) -> Result<ControlRequest, Stop> {
        let mut asked = ControlRequest::Nothing;
        for word in block.all('m') {
            match self.modes.m(word.value.floor() as i64) {
                MachineWord::End => asked = ControlRequest::End,
                MachineWord::Fan => {}
                MachineWord::Spindle => {
                    if let Some(value) = self.modes.power {
                        self.signals.spindle = Some(value);
                        self.said.add(Signal::Spindle, value);
                    }
                }
                MachineWord::Pen(signal) => self.pen_word(signal, block),
                MachineWord::Call => {
                    let Some(number) = block.value('p') else {
                        return malformed(
                            word.byte,
                            "M98 without P",
                            "write M98 P with the number of a program",
                        );
                    };
                    asked = ControlRequest::Call {
                        number,
                        times: block.value('l').unwrap_or(1.0),
                        byte: word.byte,
                    };
                }
                MachineWord::Return => asked = ControlRequest::Return { byte: word.byte },
                MachineWord::LeftOut(what, letters) => {
                    block.take(letters);
                    self.left_out('M', word, what);
                }
            }
        }
        Ok(asked)
    }

    /// M280 or M300: whether it lifts a pen, the whole program tells.
    fn pen_word(&mut self, signal: Signal, block: &Block) {
        let (value, which) = (block.value('s'), block.value('p'));
        let Some(value) = value else { return };
        match signal {
            Signal::Servo => {
                self.said.servo_line.get_or_insert(self.line);
                let which = which.unwrap_or(0.0);
                if *self.servo.get_or_insert(which) != which {
                    self.warn_once("servo", "M280 of another servo left out: the first one lifts the pen");
                    return;
                }
                self.signals.servo = Some(value);
            }
            Signal::Tone => {
                self.said.tone_line.get_or_insert(self.line);
                // With a duration it is a tone.
                if which.is_some() {
                    return;
                }
                self.signals.tone = Some(value);
            }
            Signal::Spindle => self.signals.spindle = Some(value),
        }
        self.said.add(signal, value);
    }

    /// The feed of this line's modes: units in a minute, or in a turn of the spindle; G93 counts each move apart.
    fn take_feed(&mut self, block: &Block) -> Result<(), Stop> {
        let Some(word) = block.word('f') else {
            if self.modes.feed_mode == FeedMode::InverseTime {
                self.feed = None;
            }
            return Ok(());
        };
        if word.value <= 0.0 {
            return Err(Stop { byte: word.byte, cause: Cause::Feed(word.value), line: None });
        }
        self.said_feed = word.value;
        self.feed = match self.modes.feed_mode {
            FeedMode::Minute => Some(word.value * self.scale() / 60.0),
            FeedMode::Turn => {
                let Some(turns) = self.modes.power.filter(|turns| *turns > 0.0) else {
                    let help = "give the speed of the spindle by S, or the feed in a minute by G94";
                    return malformed(word.byte, "G95: a feed for each turn of a spindle that stands", help);
                };
                Some(word.value * self.scale() * turns / 60.0)
            }
            FeedMode::InverseTime => None,
        };
        Ok(())
    }

    fn dwell(&mut self, block: &Block, byte: usize) -> Result<(), Stop> {
        match block.value('p') {
            Some(seconds) if seconds >= 0.0 => {
                self.rest(seconds);
                Ok(())
            }
            _ => malformed(byte, "G4 without P", "give the rest in seconds by P"),
        }
    }

    /// Rests where the tool is \[s\].
    pub(super) fn rest(&mut self, seconds: f64) {
        if seconds > LONGEST_DWELL {
            self.notes.add("rest", self.line, || {
                format!("a rest of {seconds} s left out: P counts seconds here, 60 at most")
            });
        } else if seconds > 0.0 && self.steps.len() < self.budget.limits().pieces {
            self.steps.push(Step::Dwell(seconds, self.signals));
        }
    }

    fn left_out(&mut self, letter: char, word: &Word, what: &str) {
        let name = format!("{letter}{}", word.value);
        self.notes.add(&name, self.line, || format!("{name} left out: {what}"));
    }

    /// Tells words that nothing has carried out, by letters.
    fn tell_untaken(&mut self, block: &Block) {
        for word in block.untaken() {
            let letter = word.letter.to_ascii_uppercase();
            let kind = format!("word {letter}");
            self.notes.add(&kind, self.line, || {
                format!("{letter}{} left out: it says nothing in this line", word.value)
            });
        }
    }

    /// The height over the plate's surface of a Z of the machine \[mm\].
    pub(super) fn over_plate(&self, z: f64) -> f64 {
        z - self.surface
    }

    pub(super) fn scale(&self) -> f64 {
        self.modes.mm_per_unit.unwrap_or(1.0)
    }

    /// Keeps a move; nothing where the tool stays.
    pub(super) fn push(
        &mut self,
        pieces: Vec<(Piece, Height)>,
        pace: Pace,
        per_minute: Option<f64>,
    ) -> Result<(), Stop> {
        let stays = |piece: &Piece, height: &Height| {
            matches!(piece, Piece::Line { from, to } if from == to) && height.derivatives(0.0).0 == 0.0
        };
        if pieces.iter().all(|(piece, height)| stays(piece, height)) {
            return Ok(());
        }
        self.take_budget(pieces.len())?;
        let sunk = |height: Height| match height {
            Height::Linear { from, to } => {
                Height::Linear { from: from - self.surface, to: to - self.surface }
            }
            Height::Cubic(controls) => Height::Cubic(controls.map(|z| z - self.surface)),
        };
        let pieces: Vec<_> = pieces.into_iter().map(|(piece, height)| (piece, sunk(height))).collect();
        let feed = match (pace, per_minute) {
            (Pace::Feed, Some(moves)) => {
                let length: f64 = pieces.iter().map(|(piece, height)| piece.length_at(height)).sum();
                Some(length * moves / 60.0)
            }
            (Pace::Feed, None) => self.feed,
            (Pace::Rapid | Pace::Withdrawal, _) => None,
        };
        let (on, z_said, signals, line) = (self.modes.is_on(), self.z_said, self.signals, self.line);
        self.steps.push(Step::Move(Move { pieces, pace, feed, on, signals, z_said, line }));
        Ok(())
    }

    /// The next stroke does not begin where the last one ended: a move of no pieces says so.
    pub(super) fn push_away(&mut self) -> Result<(), Stop> {
        self.take_budget(1)?;
        let (on, z_said, signals, line) = (self.modes.is_on(), self.z_said, self.signals, self.line);
        self.steps.push(Step::Move(Move {
            pieces: Vec::new(),
            pace: Pace::Rapid,
            feed: None,
            on,
            signals,
            z_said,
            line,
        }));
        Ok(())
    }

    pub(super) fn take_budget(&mut self, count: usize) -> Result<(), Stop> {
        let limit = self.budget.limits().pieces;
        self.budget.take(count, crate::error::Place::default).map_err(|_| Stop {
            byte: 0,
            cause: Cause::TooMany(limit),
            line: None,
        })
    }

    /// What the whole program has done.
    pub fn finish(mut self) -> Result<Done, Stop> {
        if let Some(nurbs) = self.nurbs.take() {
            match nurbs {
                // The end of the program is the end of G6.2, as any word of motion is.
                Collected::Knotted { .. } => {
                    let pieces = nurbs.pieces().map_err(|stop| stop.on(self.line))?;
                    self.push_level(pieces)?;
                }
                Collected::Uniform { .. } => {
                    let cause = Cause::Truncated("between G5.2 and G5.3".to_owned());
                    return Err(Stop { byte: 0, cause, line: None });
                }
            }
        }
        self.said.end = self.signals;
        let mut warnings = Vec::new();
        for name in self.coordinates.unplaced() {
            warnings
                .push(format!("the program does not place {name}: it counts as lying where G54 first lay"));
        }
        if self.modes.mm_per_unit.is_none() && !self.steps.is_empty() {
            warnings.push("neither G20 nor G21 in the program: millimetres are assumed".to_owned());
        }
        Ok(Done { steps: self.steps, said: self.said, notes: self.notes, warnings })
    }
}

/// Letters that mean something here; others would change what the program does.
fn check_letters(block: &Block) -> Result<(), Stop> {
    for word in &block.words {
        let letter = word.letter.to_ascii_uppercase();
        match word.letter {
            'd' | 'f' | 'g' | 'h' | 'i' | 'j' | 'k' | 'l' | 'm' | 'p' | 'q' | 'r' | 's' | 't' | 'x' | 'y'
            | 'z' | '@' | '^' => {}
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
