//! G5 (cubic), G5.1 (quadratic) and the block from G5.2 to G5.3 (NURBS), as LinuxCNC means them.

use super::block::{Block, Word};
use super::{Stop, malformed};
use crate::drawing::{Piece, PlanarNurbs, Vec2};

/// The NURBS that is being collected.
#[derive(Debug)]
pub struct Collected {
    order: usize,
    controls: Vec<(Vec2, f64)>,
    byte: usize,
}

impl Collected {
    /// Begins at the tool \[mm\]; `L` is the order, 3 if it is not given.
    pub fn new(tool: Vec2, order: Option<&Word>, byte: usize) -> Result<Self, Stop> {
        let order = match order {
            None => 3,
            Some(word) if word.value.fract() == 0.0 && (2.0..=8.0).contains(&word.value) => {
                word.value as usize
            }
            Some(word) => {
                return malformed(word.byte, format!("a NURBS of order L{}", word.value), "L is 2 to 8");
            }
        };
        Ok(Self { order, controls: vec![(tool, 1.0)], byte })
    }

    /// One more control point \[mm\] with its weight `P`.
    pub fn add(&mut self, point: Vec2, block: &Block) -> Result<(), Stop> {
        let weight = block.value('p').unwrap_or(1.0);
        if weight <= 0.0 {
            return malformed(self.byte, format!("a weight P{weight}"), "weights are positive");
        }
        self.controls.push((point, weight));
        Ok(())
    }

    /// The pieces, from where it began.
    pub fn pieces(self) -> Result<Vec<Piece>, Stop> {
        let byte = self.byte;
        PlanarNurbs::open_uniform(self.order - 1, self.controls).pieces().or_else(|why| {
            malformed(byte, why, "give at least as many points between G5.2 and G5.3 as its order L")
        })
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
