//! G2 and G3 in the XY plane, by centre or by radius.

use super::{Cause, Stop, malformed};
use crate::drawing::{EllipticalArc, Piece, Vec2, cross};
use std::f64::consts::TAU;

/// How an arc's circle is given.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Circle {
    /// Centre \[mm\].
    Centre(Vec2),
    /// Radius \[mm\], negative for the longer way round.
    Radius(f64),
}

/// The arc from `from` to `to` \[mm\]; a whole circle where they are one point and the centre is given.
///
/// Start and end must be as far from the centre as each other to 5 µm or 0.1 % (LinuxCNC's rule: never beyond
/// 0.5 mm); the centre is then moved onto the bisector so that both ends are met exactly.
pub fn piece(
    from: Vec2,
    to: Vec2,
    circle: Circle,
    counter_clockwise: bool,
    byte: usize,
) -> Result<Piece, Stop> {
    let sense = if counter_clockwise { 1.0 } else { -1.0 };
    let centre = match circle {
        Circle::Centre(centre) => centre,
        Circle::Radius(radius) => by_radius(from, to, radius, sense, byte)?,
    };
    let (start, end) = ((from - centre).norm(), (to - centre).norm());
    let gap = (start - end).abs();
    if gap > 0.5 || (gap > 0.005 && gap > 0.001 * start) {
        return Err(Stop { byte, cause: Cause::Mismatch(start, end) });
    }
    if start < 1e-6 {
        return malformed(byte, "an arc of radius 0", "give I and J, or R");
    }
    let chord = to - from;
    if chord.norm() < 1e-9 {
        return Ok(Piece::Arc(EllipticalArc::about(centre, from, sense * TAU)));
    }
    let middle = (from + to) * 0.5;
    let along = chord / chord.norm();
    let centre = centre - along * (centre - middle).dot(&along);
    let (a, b) = (from - centre, to - centre);
    let mut sweep = cross(a, b).atan2(a.dot(&b));
    if sweep * sense <= 0.0 {
        sweep += sense * TAU;
    }
    Ok(Piece::Arc(EllipticalArc::about(centre, from, sweep)))
}

fn by_radius(from: Vec2, to: Vec2, radius: f64, sense: f64, byte: usize) -> Result<Vec2, Stop> {
    let chord = to - from;
    let half = chord.norm() / 2.0;
    if half < 1e-9 {
        return malformed(byte, "an arc by radius whose end is its start", "give a whole circle by I and J");
    }
    let r = radius.abs();
    // Rounded R words of half circles fall short by a few micrometres.
    if half > r + 0.005f64.max(0.001 * r) {
        return Err(Stop { byte, cause: Cause::Mismatch(r, half) });
    }
    let height = (r * r - half * half).max(0.0).sqrt();
    let left = Vec2::new(-chord.y, chord.x) / (2.0 * half);
    Ok((from + to) * 0.5 + left * (height * sense * radius.signum()))
}
