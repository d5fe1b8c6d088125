//! A simulated instrument: it answers GeoCOM as a motorised theodolite with target recognition does.

use core::f64::consts::{PI, TAU};

use crate::angles::{Face, from_circles, to_circles};
use crate::protocol::{Answer, Code, Request};

/// What a telescope finds.
pub trait Scope {
    /// What its circles read of the target that is seen near `about` (horizontal angle from x to y, elevation \[rad\]) in this face, with all its errors, in the
    /// same count; `None` if there is no target.
    fn find(&mut self, about: [f64; 2], face: Face) -> Option<[f64; 2]>;
}

/// How far from where it is turned to the telescope finds a target \[rad\].
const WINDOW: f64 = 0.01;

/// Targets in fixed directions, and the errors of the instrument's axes.
#[derive(Clone, Debug)]
pub struct Targets {
    /// Horizontal angle from x to y, and elevation \[rad\].
    pub directions: Vec<[f64; 2]>,
    /// Collimation, trunnion axis, and index \[rad\].
    pub axes: [f64; 3],
}

impl Scope for Targets {
    fn find(&mut self, about: [f64; 2], face: Face) -> Option<[f64; 2]> {
        let off = |direction: &[f64; 2]| {
            let turn = (direction[0] - about[0] + PI).rem_euclid(TAU) - PI;
            (turn * about[1].cos()).hypot(direction[1] - about[1])
        };
        let near = self.directions.iter().min_by(|a, b| off(a).total_cmp(&off(b)));
        let [hz, v] = near.copied().filter(|direction| off(direction) < WINDOW)?;
        let [c, i, v0] = self.axes;
        let sign = if face == Face::One { 1.0 } else { -1.0 };
        Some([hz + sign * (c / v.cos() + i * v.tan()), v + sign * v0])
    }
}

/// A simulated instrument.
#[derive(Clone, Debug)]
pub struct Simulated<S> {
    scope: S,
    face: Face,
    /// What its circles read.
    circles: [f64; 2],
    /// Whether its compensator is in its range.
    pub is_level: bool,
}

impl<S: Scope> Simulated<S> {
    /// It points along x, level, in the first face.
    #[must_use]
    pub fn new(scope: S) -> Self {
        Self { scope, face: Face::One, circles: to_circles([0.0; 2], Face::One), is_level: true }
    }

    /// The answer to a line without its end; to an empty one there is none.
    pub fn answer(&mut self, line: &str) -> Option<String> {
        let line = line.trim();
        if line.is_empty() {
            return None;
        }
        let Some(request) = Request::parse(line) else {
            let no = Answer {
                transport: Code::NOT_UNDERSTOOD,
                transaction: 0,
                checked: false,
                code: Code::OK,
                values: Vec::new(),
            };
            return Some(no.to_string());
        };
        let (code, values) = match self.carry_out(&request) {
            Ok(values) => (Code::OK, values),
            Err(code) => (code, Vec::new()),
        };
        let Request { transaction, checked, .. } = request;
        let answer = Answer { transport: Code::OK, transaction, checked, code, values };
        Some(answer.to_string())
    }

    fn carry_out(&mut self, request: &Request) -> Result<Vec<String>, Code> {
        let numbers = |all: &[f64]| -> Vec<String> { all.iter().map(|one| format!("{one:.15}")).collect() };
        let texts = |all: &[&str]| -> Vec<String> { all.iter().map(|one| (*one).to_owned()).collect() };
        let face = if self.face == Face::One { "0" } else { "1" };
        match (request.rpc, &request.parameters[..]) {
            (0, _) => Ok(Vec::new()),
            // Digits of numbers, the version of GeoCOM, number, name and version of the instrument.
            (108, _) => Ok(texts(&["15"])),
            (110, _) => Ok(texts(&["1", "20", "0"])),
            (5003, _) => Ok(texts(&["1"])),
            (5004, _) => Ok(texts(&["\"simulated theodolite\""])),
            (5034, _) => Ok(texts(&["1", "0", "0"])),
            (2003 | 2107, _) if !self.is_level => Err(Code::NOT_COMPENSATED),
            (2107, _) => Ok(numbers(&self.circles)),
            (2003, _) => {
                let accuracy = 0.5 * PI / 648_000.0;
                let [hz, v] = self.circles;
                let mut values = numbers(&[hz, v, accuracy]);
                values.push("0".to_owned());
                values.extend(numbers(&[0.0, 0.0, accuracy]));
                values.extend(texts(&["0", face]));
                Ok(values)
            }
            (2026, _) => Ok(texts(&[face])),
            (9028, _) => {
                let direction = from_circles(self.circles, self.face);
                self.face = if self.face == Face::One { Face::Two } else { Face::One };
                self.circles = to_circles(direction, self.face);
                Ok(Vec::new())
            }
            (9027, &[hz, v, _, recognition, ..]) => {
                // V says the face.
                self.face = if v.rem_euclid(TAU) <= PI { Face::One } else { Face::Two };
                self.circles = [hz.rem_euclid(TAU), v.rem_euclid(TAU)];
                if recognition != 0.0 {
                    let about = from_circles(self.circles, self.face);
                    let found = self.scope.find(about, self.face).ok_or(Code::NO_TARGET)?;
                    self.circles = to_circles(found, self.face);
                }
                Ok(Vec::new())
            }
            _ => Err(Code::NOT_IMPLEMENTED),
        }
    }
}
