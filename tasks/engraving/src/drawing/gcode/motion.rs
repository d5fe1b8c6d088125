//! Moves: where a line leads, and along which curve.

use super::arc::{Arc, Circle};
use super::block::Block;
use super::machine::Machine;
use super::modes::{Distance, FeedMode, Motion};
use super::spline::{self, Collected};
use super::steps::Pace;
use super::stop::{Cause, Stop, malformed, unsupported};
use crate::drawing::{Height, Piece, Vec2, Vec3};

/// The most turns of one arc.
const MOST_TURNS: f64 = 10_000.0;

impl Machine<'_> {
    /// A word of motion ends what the one before it collects.
    pub(super) fn change_of_motion(&mut self, before: Motion, block: &Block) -> Result<(), Stop> {
        let now = self.modes.motion;
        if before == Motion::KnottedNurbs
            && now != before
            && let Some(nurbs) = self.nurbs.take()
        {
            let pieces = nurbs.pieces()?;
            self.push_level(pieces)?;
        }
        if now != Motion::Nurbs
            && self.nurbs.is_some()
            && before == Motion::Nurbs
            && let Some(byte) = block.first("g")
        {
            return malformed(byte, "a move between G5.2 and G5.3", "end the spline by G5.3 first");
        }
        if !matches!((before, now), (Motion::Cycle(_), Motion::Cycle(_))) {
            self.sticky.forget();
        }
        Ok(())
    }

    /// The motion of a line, if it has one.
    pub(super) fn motion(&mut self, block: &Block, in_machine: bool) -> Result<(), Stop> {
        match self.modes.motion {
            Motion::Nurbs | Motion::KnottedNurbs => return self.control_point(block, in_machine),
            Motion::Cycle(cycle) => return self.cycle(cycle, block, in_machine),
            _ => {}
        }
        let arc = matches!(self.modes.motion, Motion::Clockwise | Motion::CounterClockwise);
        let Some(byte) = block.first("xyz@^").or_else(|| if arc { block.first("ijk") } else { None }) else {
            return Ok(());
        };
        let to = self.target(block, in_machine)?;
        if block.has("xy@^") {
            self.said.first_move.get_or_insert(self.signals);
        }
        let pieces = self.pieces(block, to, byte)?;
        let pace = if self.modes.motion == Motion::Rapid { Pace::Rapid } else { Pace::Feed };
        let per_minute = match (pace, self.modes.feed_mode) {
            (Pace::Feed, FeedMode::InverseTime) => match block.value('f') {
                Some(moves) => Some(moves),
                None => {
                    return malformed(
                        byte,
                        "G93: a move without F",
                        "give each line its own F, or write G94",
                    );
                }
            },
            _ => None,
        };
        if in_machine {
            return self.go_in_machine(to, byte);
        }
        self.push(pieces, pace, per_minute)?;
        self.tool = to;
        Ok(())
    }

    /// G53: where the machine's zero lies over the plate, no program says.
    fn go_in_machine(&mut self, to: Vec3, byte: usize) -> Result<(), Stop> {
        if self.modes.motion != Motion::Rapid {
            let help = "use G0 with G53, or work coordinates";
            return unsupported(byte, "G53: a cut in the machine's coordinates", help);
        }
        self.warn_once("G53", "G53: the tool lifts; where the machine's zero lies, the program does not say");
        self.push_away()?;
        self.tool = Vec3::new(to.x, to.y, self.tool.z.max(1.0));
        Ok(())
    }

    /// Where the coordinates of a line lead \[mm, machine\].
    pub(super) fn target(&mut self, block: &Block, in_machine: bool) -> Result<Vec3, Stop> {
        let scale = self.scale();
        let relative = self.modes.distance == Distance::Relative && !in_machine;
        let origin = if in_machine { Vec3::zeros() } else { self.coordinates.origin() };
        let mut to = self.tool;
        if block.has("@^") {
            to = self.polar(block, origin, relative)?;
        }
        for (axis, letter) in ['x', 'y', 'z'].into_iter().enumerate() {
            let Some(word) = block.word(letter) else { continue };
            let mm = word.value * scale + if relative { self.tool[axis] } else { origin[axis] };
            if mm.abs() >= 1e7 {
                let what = letter.to_ascii_uppercase().to_string();
                return Err(Stop { byte: word.byte, cause: Cause::Range(what, mm), line: None });
            }
            to[axis] = mm;
            self.z_said |= letter == 'z';
        }
        Ok(to)
    }

    /// `@` is the distance from the active zero and `^` the angle about it, or what is added to them.
    fn polar(&self, block: &Block, origin: Vec3, relative: bool) -> Result<Vec3, Stop> {
        let byte = block.first("@^").unwrap_or(0);
        if block.has("xy") {
            return malformed(byte, "polar words beside X or Y", "give @ and ^, or X and Y");
        }
        let now = (self.tool - origin).xy();
        let (distance, angle) =
            (block.value('@').map(|d| d * self.scale()), block.value('^').map(f64::to_radians));
        if now.norm() < 1e-9 && (relative || angle.is_none()) {
            let help = "at the zero there is no angle: give @ and ^ in absolute coordinates (G90)";
            return malformed(byte, "polar words that go on from the zero", help);
        }
        let old = (now.norm(), now.y.atan2(now.x));
        let (distance, angle) = if relative {
            (old.0 + distance.unwrap_or(0.0), old.1 + angle.unwrap_or(0.0))
        } else {
            (distance.unwrap_or(old.0), angle.unwrap_or(old.1))
        };
        if distance.abs() >= 1e7 {
            return Err(Stop { byte, cause: Cause::Range("@".to_owned(), distance), line: None });
        }
        let place = origin.xy() + Vec2::new(angle.cos(), angle.sin()) * distance;
        Ok(Vec3::new(place.x, place.y, self.tool.z))
    }

    fn pieces(&mut self, block: &Block, to: Vec3, byte: usize) -> Result<Vec<(Piece, Height)>, Stop> {
        let scale = self.scale();
        let pair = |a, b| match (block.value(a), block.value(b)) {
            (None, None) => None,
            (x, y) => Some(Vec2::new(x.unwrap_or(0.0), y.unwrap_or(0.0)) * scale),
        };
        let tangent = self.tangent.take();
        let (from, end) = (self.tool.xy(), to.xy());
        let piece = match self.modes.motion {
            Motion::Rapid | Motion::Line => return Ok(vec![straight(self.tool, to)]),
            Motion::Clockwise | Motion::CounterClockwise => return self.arc(block, to, byte)?.pieces(byte),
            Motion::Cubic => {
                let Some(arrive) = pair('p', 'q') else {
                    return malformed(byte, "G5 without P and Q", "give the end's control point by P and Q");
                };
                self.tangent = Some(-arrive);
                spline::cubic(from, end, pair('i', 'j'), arrive, tangent, byte)?
            }
            Motion::Quadratic => match pair('i', 'j') {
                Some(control) => Piece::quadratic(from, from + control, end),
                None => return malformed(byte, "G5.1 without I and J", "give the control point by I and J"),
            },
            Motion::Nurbs | Motion::KnottedNurbs | Motion::Cycle(_) | Motion::None => {
                return malformed(
                    byte,
                    "coordinates before any G0, G1, G2 or G3",
                    "begin the line with a motion word",
                );
            }
        };
        self.check_level(block, to)?;
        Ok(vec![(piece, Height::level(to.z))])
    }

    /// Splines lie level: only X and Y may change.
    fn check_level(&self, block: &Block, to: Vec3) -> Result<(), Stop> {
        if (to.z - self.tool.z).abs() > 1e-9 {
            let help = "splines move X and Y; move Z by G1 before it";
            return malformed(block.first("z").unwrap_or(0), "a spline that changes Z", help);
        }
        if self.modes.plane != super::modes::Plane::Xy {
            let help = "splines lie in the plane of the plate: write G17";
            return unsupported(block.first("xy").unwrap_or(0), "a spline in the plane G18 or G19", help);
        }
        Ok(())
    }

    fn arc(&self, block: &Block, to: Vec3, byte: usize) -> Result<Arc, Stop> {
        let plane = self.modes.plane;
        let (first, second) = plane.centre_letters();
        let given = [first, second].map(|letter| block.value(letter).map(|value| value * self.scale()));
        let names = format!("{} and {}", first.to_ascii_uppercase(), second.to_ascii_uppercase());
        let turns = match block.word('p') {
            None => 1,
            Some(word) if word.value.fract() == 0.0 && (1.0..=MOST_TURNS).contains(&word.value) => {
                word.value as u32
            }
            Some(word) => {
                let what = format!("an arc of P{} turns", word.value);
                return malformed(word.byte, what, "P is a whole number of turns from 1");
            }
        };
        let (here, _) = plane.split(self.tool);
        let origin = plane.split(self.coordinates.origin()).0;
        let circle = match (given, block.value('r')) {
            ([None, None], None) => {
                return malformed(byte, "an arc without centre or radius", format!("give {names}, or R"));
            }
            ([None, None], Some(r)) => Circle::Radius(r * self.scale()),
            (_, Some(_)) => {
                return malformed(byte, "an arc with a centre and a radius", format!("give {names}, or R"));
            }
            ([a, b], None) => match self.modes.centres {
                Distance::Relative => Circle::Centre(here + Vec2::new(a.unwrap_or(0.0), b.unwrap_or(0.0))),
                Distance::Absolute => match (a, b) {
                    (Some(a), Some(b)) => Circle::Centre(origin + Vec2::new(a, b)),
                    _ => {
                        let help = format!("absolute centres (G90.1) need {names}");
                        return malformed(byte, "an arc with half a centre", help);
                    }
                },
            },
        };
        let counter_clockwise = self.modes.motion == Motion::CounterClockwise;
        Ok(Arc { plane, from: self.tool, to, circle, counter_clockwise, turns })
    }

    /// A line of a NURBS.
    fn control_point(&mut self, block: &Block, in_machine: bool) -> Result<(), Stop> {
        let uniform = self.modes.motion == Motion::Nurbs;
        let says = if uniform { "xyz@^pl" } else { "xyz@^kr" };
        let begins = self.nurbs.is_none();
        let Some(byte) = block.first(says).or_else(|| if begins { block.first("g") } else { None }) else {
            return Ok(());
        };
        let to = self.target(block, in_machine)?;
        self.check_level(block, to)?;
        let tool = self.tool.xy();
        let mut nurbs = match self.nurbs.take() {
            Some(nurbs) => nurbs,
            None if uniform => Collected::uniform(tool, block, byte)?,
            None => Collected::knotted(block, byte)?,
        };
        self.take_budget(1)?;
        nurbs.add(tool, to.xy(), block, begins)?;
        self.nurbs = Some(nurbs);
        self.tool = to;
        Ok(())
    }

    pub(super) fn end_nurbs(&mut self, byte: usize) -> Result<(), Stop> {
        match self.nurbs.take() {
            None => malformed(byte, "G5.3 without G5.2", "begin the spline by G5.2"),
            Some(collected) => {
                self.modes.motion = Motion::None;
                let pieces = collected.pieces()?;
                self.push_level(pieces)
            }
        }
    }

    /// Keeps pieces at the tool's height.
    pub(super) fn push_level(&mut self, pieces: Vec<Piece>) -> Result<(), Stop> {
        let height = Height::level(self.tool.z);
        self.push(pieces.into_iter().map(|piece| (piece, height)).collect(), Pace::Feed, None)
    }

    /// A straight move from where the tool is.
    pub(super) fn go(&mut self, to: Vec3, pace: Pace) -> Result<(), Stop> {
        self.push(vec![straight(self.tool, to)], pace, None)?;
        self.tool = to;
        Ok(())
    }

    /// Says something of a kind once.
    pub(super) fn warn_once(&mut self, kind: &str, what: &str) {
        self.notes.add(kind, self.line, || what.to_owned());
    }
}

fn straight(from: Vec3, to: Vec3) -> (Piece, Height) {
    (Piece::Line { from: from.xy(), to: to.xy() }, Height::Linear { from: from.z, to: to.z })
}
