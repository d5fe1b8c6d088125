//! Which moves of a program cut, how deep and how fast: the rule of the module [`super`].

use super::notes::Notes;
use super::pen::{Pen, PenLift};
use super::steps::{Done, Move, Pace, Said, Signal, Step};
use super::stop::{Cause, Stop, unsupported};
use crate::drawing::{Height, Manner, Piece, Stroke};

/// What is cut.
#[derive(Debug)]
pub struct Cuts {
    pub strokes: Vec<Stroke>,
    pub warnings: Vec<String>,
    /// What was found where nothing is cut.
    pub nothing: Option<String>,
}

/// Below this the tip is in the material \[mm\].
const SURFACE: f64 = -1e-9;
/// The deepest cut \[mm\], as the option `--depth` allows it.
pub const DEEPEST: f64 = 20.0;

/// The rule that a program is read by.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Rule {
    /// What is below Z0.
    Depth,
    /// What is done with the pen down, at any Z.
    Pen(Pen),
    /// What is on the plate while spindle or laser are on.
    Beam,
    /// What is on the plate.
    All,
}

/// The strokes of what a program has done, cut while this lets them.
pub fn cuts(done: Done, lift: PenLift) -> Result<Cuts, Stop> {
    let Done { steps, said, mut notes, warnings: mut after } = done;
    let rule = rule(&steps, &said, lift)?;
    let mut warnings: Vec<String> = what_was_found(rule, &steps, lift).into_iter().collect();
    for (signal, line) in [(Signal::Servo, said.servo_line), (Signal::Tone, said.tone_line)] {
        let carried_out = matches!(rule, Rule::Pen(pen) if pen.signal == signal);
        if let Some(line) = line.filter(|_| !carried_out) {
            let what = match said.of(signal) {
                [_, _, ..] => {
                    format!("{signal} left out; if it lifts the pen, say --pen {}", name_of(signal))
                }
                _ => format!("{signal} left out: an M word of another machine"),
            };
            notes.add(&signal.to_string(), line, || what);
        }
    }
    let nothing = match rule {
        Rule::Depth | Rule::Pen(_) => None,
        Rule::Beam | Rule::All => nothing(&steps),
    };
    let mut chain = Chain::default();
    for step in steps {
        let one = match step {
            Step::Dwell(seconds, signals) => {
                // A pen that is up rests until its servo has moved, not on the plate.
                if !matches!(rule, Rule::Pen(pen) if !pen.is_down(&signals)) {
                    chain.rest(seconds);
                }
                continue;
            }
            Step::Move(one) => one,
        };
        if rule == Rule::Depth && one.pace == Pace::Rapid {
            check_rapid(&one, &mut notes)?;
        }
        for (piece, height) in &one.pieces {
            if one.pace == Pace::Withdrawal && height.range().1 < 0.0 {
                chain.end();
                chain.goes_on = true;
                continue;
            }
            if one.pace != Pace::Feed {
                chain.travel(height, one.z_said);
                continue;
            }
            if rule != Rule::Depth {
                let cut = match rule {
                    Rule::Depth => false,
                    Rule::Pen(pen) => pen.is_down(&one.signals),
                    Rule::Beam => one.on && on_the_plate(&one),
                    Rule::All => on_the_plate(&one),
                };
                if cut {
                    chain.cut(piece.clone(), None, one.feed);
                } else {
                    chain.travel(height, one.z_said);
                }
                continue;
            }
            if height.range().0 < -DEEPEST {
                let what = format!("{:.3} mm below the plate, whose surface is Z0", -height.range().0);
                let help = format!(
                    "at most {DEEPEST} mm; --surface says which Z of the file is the plate's surface"
                );
                return unsupported(0, what, help).map_err(|stop: Stop| stop.on(one.line));
            }
            let mut ends = height.crossings(0.0);
            ends.insert(0, 0.0);
            ends.push(1.0);
            for part in ends.windows(2) {
                let height = height.part(part[0], part[1]);
                if height.at(0.5) < SURFACE {
                    chain.cut(piece.part(part[0], part[1]), Some(height), one.feed);
                } else {
                    chain.travel(&height, one.z_said);
                }
            }
        }
        if one.pieces.is_empty() {
            chain.end();
        }
    }
    chain.end();
    warnings.extend(notes.sentences());
    warnings.append(&mut after);
    Ok(Cuts { strokes: chain.strokes, warnings, nothing })
}

fn feeds(steps: &[Step]) -> impl Iterator<Item = &Move> {
    steps.iter().filter_map(|step| match step {
        Step::Move(one) if one.pace == Pace::Feed => Some(one),
        Step::Move(_) | Step::Dwell(..) => None,
    })
}

fn rule(steps: &[Step], said: &Said, lift: PenLift) -> Result<Rule, Stop> {
    let deep = feeds(steps).any(|one| one.pieces.iter().any(|(_, height)| height.range().0 < SURFACE));
    let beam = feeds(steps).any(|one| one.on && on_the_plate(one));
    let found = |signal| Pen::find(signal, None, said, steps);
    Ok(match lift {
        PenLift::Auto | PenLift::Height if deep => Rule::Depth,
        PenLift::Height => Rule::All,
        PenLift::Auto => {
            let on_spindle = || Pen::find_on_spindle(said, steps);
            let pen = found(Signal::Servo).or_else(|| found(Signal::Tone));
            match pen.or_else(on_spindle) {
                Some(pen) => Rule::Pen(pen),
                None if beam => Rule::Beam,
                None => Rule::All,
            }
        }
        PenLift::Word { signal: Signal::Spindle, down: None } if beam => {
            Pen::find_on_spindle(said, steps).map_or(Rule::Beam, Rule::Pen)
        }
        PenLift::Word { signal, down } => match Pen::find(signal, down, said, steps) {
            Some(pen) => Rule::Pen(pen),
            None => {
                let what = format!("--pen {} in a program whose {signal} has no two values", name_of(signal));
                return Err(Stop { byte: 0, cause: Cause::NoPen(what), line: None });
            }
        },
    })
}

/// A signal as the option names it.
fn name_of(signal: Signal) -> &'static str {
    match signal {
        Signal::Spindle => "m3",
        Signal::Servo => "m280",
        Signal::Tone => "m300",
    }
}

/// What to say of a pen or a beam, unless the options have said it all.
fn what_was_found(rule: Rule, steps: &[Step], lift: PenLift) -> Option<String> {
    match rule {
        Rule::Pen(_) if matches!(lift, PenLift::Word { down: Some(_), .. }) => None,
        Rule::Pen(Pen { signal, down, up }) => Some(format!(
            "{signal} lifts a pen: S{down} is down, S{up} is up, and what is drawn with the pen down is cut; \
             --pen {}:{up} says that S{up} is down, --pen z that Z decides",
            name_of(signal)
        )),
        Rule::Beam => {
            let off = feeds(steps).filter(|one| !one.on && on_the_plate(one)).count();
            let moves = if off == 1 { "feed move is" } else { "feed moves are" };
            (off > 0).then(|| {
                format!("{off} {moves} not cut, because M3 or M4 is off or S is 0; --pen z cuts them all")
            })
        }
        Rule::Depth | Rule::All => None,
    }
}

/// Whether a move that is not below Z0 is at Z0, or at a height that the program does not say.
fn on_the_plate(one: &Move) -> bool {
    !one.z_said || one.pieces.iter().all(|(_, height)| height.range().1 <= -SURFACE)
}

/// What to say where all feed moves are above the plate.
fn nothing(steps: &[Step]) -> Option<String> {
    let lowest = |one: &Move| one.pieces.iter().map(|(_, height)| height.range().0).fold(f64::MAX, f64::min);
    let above = feeds(steps).filter(|one| !on_the_plate(one));
    let (count, low) = above.fold((0, f64::MAX), |(n, low), one| (n + 1, low.min(lowest(one))));
    let all = feeds(steps).all(|one| !on_the_plate(one));
    (all && count > 0).then(|| format!("all {count} feed moves are above the plate, at Z{low:.3} or higher"))
}

/// A rapid move in the material is an error of the program, or an unusual way to put a pen down.
fn check_rapid(one: &Move, notes: &mut Notes) -> Result<(), Stop> {
    for (piece, height) in &one.pieces {
        let (from, to) = (height.at(0.0), height.at(1.0));
        let sideways = piece.length() > 1e-6;
        if sideways && from < SURFACE && to < SURFACE {
            let help = "lift to Z above 0 before G0, or use G1";
            return unsupported(0, "a rapid move (G0) through the plate, below Z0", help)
                .map_err(|stop: Stop| stop.on(one.line));
        }
        let what = if sideways && from.min(to) < SURFACE {
            "enters or leaves the plate sideways by G0: the arm goes straight down and up"
        } else if to < from && to < SURFACE {
            "goes down into the plate by G0: the arm goes down slowly"
        } else {
            continue;
        };
        notes.add(what, one.line, || what.to_owned());
    }
    Ok(())
}

/// Strokes as they grow.
#[derive(Default)]
struct Chain {
    strokes: Vec<Stroke>,
    pieces: Vec<(Piece, Option<Height>)>,
    feed: Option<f64>,
    /// The greatest height of the travel since the last stroke.
    highest: Option<f64>,
    /// The stroke goes on from the end of the last one.
    goes_on: bool,
}

impl Chain {
    fn cut(&mut self, piece: Piece, height: Option<Height>, feed: Option<f64>) {
        let same = match (self.feed, feed) {
            (Some(a), Some(b)) => (a - b).abs() < 1e-9,
            (a, b) => a == b,
        };
        if !same && !self.pieces.is_empty() {
            self.end();
            self.goes_on = true;
        }
        self.feed = feed;
        self.pieces.push((piece, height));
    }

    fn travel(&mut self, height: &Height, z_said: bool) {
        self.end();
        self.goes_on = false;
        let high = height.range().1;
        if z_said && high > 0.0 {
            self.highest = Some(self.highest.map_or(high, |other| other.max(high)));
        }
    }

    fn rest(&mut self, seconds: f64) {
        if self.pieces.is_empty() {
            return;
        }
        self.end();
        if let Some(stroke) = self.strokes.pop() {
            let manner = Manner { dwell: seconds, ..*stroke.manner() };
            self.strokes.push(stroke.cut_so(manner));
        }
        self.goes_on = true;
    }

    fn end(&mut self) {
        let pieces = std::mem::take(&mut self.pieces);
        if pieces.is_empty() {
            return;
        }
        let manner =
            Manner { feed: self.feed, dwell: 0.0, approach: self.highest.take(), goes_on: self.goes_on };
        let level = pieces.iter().all(|(_, height)| height.is_none());
        let stroke = if level {
            Stroke::new(pieces.into_iter().map(|(piece, _)| piece).collect())
                .map(|stroke| stroke.cut_so(manner))
        } else {
            let at = |height: Option<Height>| height.unwrap_or(Height::level(0.0));
            Stroke::with_heights(
                pieces.into_iter().map(|(piece, height)| (piece, at(height))).collect(),
                manner,
            )
        };
        self.strokes.extend(stroke);
        self.goes_on = false;
    }
}
