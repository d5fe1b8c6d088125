//! Which moves of a program cut: the rule of the module [`super`].

use super::{Stop, unsupported};
use crate::drawing::{Piece, Stroke};

/// How a move was commanded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pace {
    /// G0.
    Rapid,
    /// Any other.
    Feed,
}

/// A move in the plane.
#[derive(Clone, Debug)]
pub struct PlaneMove {
    pub pieces: Vec<Piece>,
    pub pace: Pace,
    /// Whether an end lies below Z0.
    pub deep: bool,
    /// Whether spindle or laser were on.
    pub on: bool,
    /// Where its line is, for a rapid through the plate.
    pub line: usize,
}

/// The strokes of a program's moves.
pub fn strokes(moves: Vec<PlaneMove>) -> Result<Vec<Stroke>, Stop> {
    let feeds = || moves.iter().filter(|m| m.pace == Pace::Feed);
    let by_depth = feeds().any(|m| m.deep);
    let by_beam = !by_depth && feeds().any(|m| m.on);
    if by_depth && let Some(bad) = moves.iter().find(|m| m.pace == Pace::Rapid && m.deep) {
        return unsupported(
            0,
            format!("line {} moves rapidly (G0) through the plate, below Z0", bad.line),
            "lift to Z above 0 before G0, or use G1",
        );
    }
    let cuts = |m: &PlaneMove| m.pace == Pace::Feed && if by_depth { m.deep } else { !by_beam || m.on };
    let mut strokes = Vec::new();
    let mut chain: Vec<Piece> = Vec::new();
    for m in moves {
        if cuts(&m) {
            chain.extend(m.pieces);
        } else {
            strokes.extend(Stroke::new(std::mem::take(&mut chain)));
        }
    }
    strokes.extend(Stroke::new(chain));
    Ok(strokes)
}
