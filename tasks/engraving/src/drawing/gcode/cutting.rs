//! Which moves of a program cut, how deep and how fast: the rule of the module [`super`].

use super::{Stop, unsupported};
use crate::drawing::{Height, Manner, Piece, Stroke};

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
    /// G4, or at the bottom of a hole \[s\].
    Dwell(f64),
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
    /// Whether the program has said any Z yet.
    pub z_said: bool,
    /// Its line, from 0.
    pub line: usize,
}

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
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Rule {
    /// What is below Z0.
    Depth,
    /// What is on the plate while spindle or laser are on.
    Beam,
    /// What is on the plate.
    All,
}

/// The strokes of a program's steps.
pub fn cuts(steps: Vec<Step>) -> Result<Cuts, Stop> {
    let rule = rule(&steps);
    let nothing = if rule == Rule::Depth { None } else { nothing(&steps) };
    let mut chain = Chain::default();
    let mut warnings = Vec::new();
    for step in steps {
        let one = match step {
            Step::Dwell(seconds) => {
                chain.rest(seconds);
                continue;
            }
            Step::Move(one) => one,
        };
        if rule == Rule::Depth && one.pace == Pace::Rapid {
            check_rapid(&one, &mut warnings)?;
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
                if on_the_plate(&one) && (rule == Rule::All || one.on) {
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
    Ok(Cuts { strokes: chain.strokes, warnings, nothing })
}

fn feeds(steps: &[Step]) -> impl Iterator<Item = &Move> {
    steps.iter().filter_map(|step| match step {
        Step::Move(one) if one.pace == Pace::Feed => Some(one),
        Step::Move(_) | Step::Dwell(_) => None,
    })
}

fn rule(steps: &[Step]) -> Rule {
    let deep = |one: &Move| one.pieces.iter().any(|(_, height)| height.range().0 < SURFACE);
    if feeds(steps).any(deep) {
        Rule::Depth
    } else if feeds(steps).any(|one| one.on && on_the_plate(one)) {
        Rule::Beam
    } else {
        Rule::All
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
fn check_rapid(one: &Move, warnings: &mut Vec<String>) -> Result<(), Stop> {
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
        if warnings.len() < 3 {
            warnings.push(format!("line {}: {what}", one.line + 1));
        }
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
