//! G2 and G3 in any of the three planes, by centre or by radius, over several turns, and rising along the third axis.

use std::f64::consts::TAU;

use super::modes::Plane;
use super::stop::{Cause, Stop, malformed};
use crate::drawing::{EllipticalArc, Height, Piece, Vec2, Vec3, cross};

/// How an arc's circle is given, in the plane's two axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Circle {
    /// Centre \[mm\].
    Centre(Vec2),
    /// Radius \[mm\], negative for the longer arc.
    Radius(f64),
}

/// An arc as the program gives it.
#[derive(Clone, Copy, Debug)]
pub struct Arc {
    pub plane: Plane,
    pub from: Vec3,
    pub to: Vec3,
    pub circle: Circle,
    pub counter_clockwise: bool,
    /// Turns that are begun, 1 or more.
    pub turns: u32,
}

/// The largest part of an arc outside of G17 that becomes one cubic curve \[rad\]: at a radius of 1 m it lies within
/// 6 nm of the arc, as the error grows with the sixth power of the angle from 0.27 ‰ of the radius at a quarter turn.
const PART: f64 = TAU / 24.0;

impl Arc {
    /// The pieces with their heights: a whole circle where start and end are one point and the centre is given.
    ///
    /// Start and end must be as far from the centre as each other to 5 µm or 0.1 % (LinuxCNC's rule: never beyond
    /// 0.5 mm); the centre is then moved onto the bisector so that both ends are met exactly.
    pub fn pieces(&self, byte: usize) -> Result<Vec<(Piece, Height)>, Stop> {
        let (from, rise_from) = self.plane.split(self.from);
        let (to, rise_to) = self.plane.split(self.to);
        let (centre, sweep) = self.circle(from, to, byte)?;
        let parts = match self.plane {
            Plane::Xy => (sweep.abs() / TAU - 1e-9).ceil(),
            Plane::Zx | Plane::Yz => (sweep.abs() / PART - 1e-9).ceil(),
        };
        let parts = parts.max(1.0) as u32;
        let part = |k: u32| {
            let (a, b) = (f64::from(k) / f64::from(parts), f64::from(k + 1) / f64::from(parts));
            let rise = |share: f64| rise_from + (rise_to - rise_from) * share;
            let start = centre + turned(from - centre, sweep * a);
            let sweep = sweep * (b - a);
            match self.plane {
                Plane::Xy => (
                    Piece::Arc(EllipticalArc::about(centre, start, sweep)),
                    Height::Linear { from: rise(a), to: rise(b) },
                ),
                Plane::Zx | Plane::Yz => self.cubic(centre, start, sweep, rise(a), rise(b)),
            }
        };
        Ok((0..parts).map(part).collect())
    }

    /// Centre and signed angle in the plane's axes.
    fn circle(&self, from: Vec2, to: Vec2, byte: usize) -> Result<(Vec2, f64), Stop> {
        let sense = if self.counter_clockwise { 1.0 } else { -1.0 };
        let more = sense * TAU * f64::from(self.turns - 1);
        let centre = match self.circle {
            Circle::Centre(centre) => centre,
            Circle::Radius(radius) => by_radius(from, to, radius, sense, byte)?,
        };
        let (start, end) = ((from - centre).norm(), (to - centre).norm());
        let gap = (start - end).abs();
        if gap > 0.5 || (gap > 0.005 && gap > 0.001 * start) {
            return Err(Stop { byte, cause: Cause::Mismatch(start, end), line: None });
        }
        if start < 1e-6 {
            return malformed(byte, "an arc of radius 0", "give the centre by two of I, J, K, or R");
        }
        let chord = to - from;
        if chord.norm() < 1e-9 {
            return Ok((centre, sense * TAU + more));
        }
        let middle = (from + to) * 0.5;
        let along = chord / chord.norm();
        let centre = centre - along * (centre - middle).dot(&along);
        let (a, b) = (from - centre, to - centre);
        let mut sweep = cross(a, b).atan2(a.dot(&b));
        if sweep * sense <= 0.0 {
            sweep += sense * TAU;
        }
        Ok((centre, sweep + more))
    }

    /// A part of an arc that does not lie in the plane of the plate, as a Bézier curve in space.
    fn cubic(&self, centre: Vec2, start: Vec2, sweep: f64, low: f64, high: f64) -> (Piece, Height) {
        let reach = 4.0 / 3.0 * (sweep / 4.0).tan();
        let a = start - centre;
        let b = turned(a, sweep);
        let (along_a, along_b) = (turned(a, TAU / 4.0) * reach, turned(b, TAU / 4.0) * reach);
        let third = (high - low) / 3.0;
        let controls = [
            self.plane.join(centre + a, low),
            self.plane.join(centre + a + along_a, low + third),
            self.plane.join(centre + b - along_b, high - third),
            self.plane.join(centre + b, high),
        ];
        (Piece::Cubic(controls.map(|p| p.xy())), Height::Cubic(controls.map(|p| p.z)))
    }
}

fn turned(v: Vec2, angle: f64) -> Vec2 {
    let (sin, cos) = angle.sin_cos();
    Vec2::new(v.x * cos - v.y * sin, v.x * sin + v.y * cos)
}

fn by_radius(from: Vec2, to: Vec2, radius: f64, sense: f64, byte: usize) -> Result<Vec2, Stop> {
    let chord = to - from;
    let half = chord.norm() / 2.0;
    if half < 1e-9 {
        return malformed(
            byte,
            "an arc by radius whose end is its start",
            "give a whole circle by its centre",
        );
    }
    let r = radius.abs();
    // Rounded R words of half circles fall short by a few micrometres.
    if half > r + 0.005f64.max(0.001 * r) {
        return Err(Stop { byte, cause: Cause::Mismatch(r, half), line: None });
    }
    let height = (r * r - half * half).max(0.0).sqrt();
    let left = Vec2::new(-chord.y, chord.x) / (2.0 * half);
    Ok((from + to) * 0.5 + left * (height * sense * radius.signum()))
}
