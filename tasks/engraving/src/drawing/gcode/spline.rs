//! G5 (cubic), G5.1 (quadratic), the block from G5.2 to G5.3 as LinuxCNC means it, and G6.2 as Fanuc does (NURBS).

use super::block::{Block, Word};
use super::stop::{Stop, malformed};
use crate::drawing::{Piece, PlanarNurbs, Vec2};

/// The NURBS that is being collected.
#[derive(Debug)]
pub enum Collected {
    /// G5.2: control points with weights over uniform knots.
    Uniform { order: usize, controls: Vec<(Vec2, f64)>, byte: usize },
    /// G6.2: with knots of its own.
    Knotted { order: usize, controls: Vec<(Vec2, f64)>, knots: Vec<f64>, byte: usize },
}

/// The order of a NURBS, as a word gives it.
fn order(word: Option<&Word>, default: usize, most: usize) -> Result<usize, Stop> {
    match word {
        None => Ok(default),
        Some(word) if word.value.fract() == 0.0 && (2.0..=most as f64).contains(&word.value) => {
            Ok(word.value as usize)
        }
        Some(word) => {
            let letter = word.letter.to_ascii_uppercase();
            malformed(
                word.byte,
                format!("a NURBS of order {letter}{}", word.value),
                format!("it is 2 to {most}"),
            )
        }
    }
}

impl Collected {
    /// G5.2: begins at the tool \[mm\] with the weight of a `P` that has no coordinates beside it; `L` is the order, 3 if it
    /// is not given.
    pub fn uniform(tool: Vec2, block: &Block, byte: usize) -> Result<Self, Stop> {
        let order = order(block.word('l'), 3, 8)?;
        let weight = if block.has("xy@^") { 1.0 } else { weight(block, 'p')? };
        Ok(Self::Uniform { order, controls: vec![(tool, weight)], byte })
    }

    /// G6.2: `P` is the order, 4 if it is not given.
    pub fn knotted(block: &Block, byte: usize) -> Result<Self, Stop> {
        let order = order(block.word('p'), 4, 4)?;
        Ok(Self::Knotted { order, controls: Vec::new(), knots: Vec::new(), byte })
    }

    /// One more line: a control point \[mm\], if it has coordinates, with its weight and its knot.
    pub fn add(&mut self, tool: Vec2, point: Vec2, block: &Block, first: bool) -> Result<(), Stop> {
        let placed = block.has("xy@^");
        match self {
            Self::Uniform { controls, byte, .. } => {
                if !placed {
                    return match block.first("p") {
                        Some(at) if !first => {
                            let help = "only the first line, G5.2 itself, may give a P without X and Y";
                            malformed(at, "a weight without its point", help)
                        }
                        _ => Ok(()),
                    };
                }
                if block.has("xy") && !(block.has("x") && block.has("y")) {
                    return malformed(*byte, "a control point with X or Y alone", "give both");
                }
                controls.push((point, weight(block, 'p')?));
            }
            Self::Knotted { controls, knots, byte, .. } => {
                let Some(knot) = block.value('k') else {
                    return malformed(*byte, "a line of G6.2 without its knot", "give K in each line");
                };
                if placed && knots.len() > controls.len() {
                    return malformed(
                        *byte,
                        "a control point after lines of knots alone",
                        "points come first",
                    );
                }
                knots.push(knot);
                if placed {
                    controls.push((point, weight(block, 'r')?));
                } else if controls.is_empty() {
                    controls.push((tool, weight(block, 'r')?));
                }
                if let [(start, _)] = controls[..]
                    && (start - tool).norm() > 1e-3
                {
                    let help = "move to the first control point before G6.2";
                    return malformed(*byte, "a NURBS that does not begin where the tool is", help);
                }
            }
        }
        Ok(())
    }

    /// The pieces, from where it began.
    pub fn pieces(self) -> Result<Vec<Piece>, Stop> {
        let (nurbs, byte, help) = match self {
            Self::Uniform { order, controls, byte } => (
                PlanarNurbs::open_uniform(order - 1, controls),
                byte,
                "give at least as many points between G5.2 and G5.3 as its order L",
            ),
            Self::Knotted { order, controls, knots, byte } => (
                PlanarNurbs { degree: order - 1, knots, controls },
                byte,
                "G6.2 has a knot K in each line of a point, and as many lines of K alone as its order P",
            ),
        };
        nurbs.pieces().or_else(|why| malformed(byte, why, help))
    }
}

fn weight(block: &Block, letter: char) -> Result<f64, Stop> {
    match block.word(letter) {
        None => Ok(1.0),
        Some(word) if word.value > 0.0 => Ok(word.value),
        Some(word) => {
            let letter = letter.to_ascii_uppercase();
            malformed(word.byte, format!("a weight {letter}{}", word.value), "weights are positive")
        }
    }
}

/// G5: control points at the start + (I, J) and at the end + (P, Q); without I and J it goes on tangentially.
pub fn cubic(
    from: Vec2,
    to: Vec2,
    leave: Option<Vec2>,
    arrive: Vec2,
    tangent: Option<Vec2>,
    byte: usize,
) -> Result<Piece, Stop> {
    match leave.or(tangent) {
        Some(leave) => Ok(Piece::Cubic([from, from + leave, to + arrive, to])),
        None => malformed(byte, "G5 without I and J", "the first G5 of a chain needs both"),
    }
}
